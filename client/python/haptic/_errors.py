"""Statuses of gRPC, with the google.rpc details in them, as one exception."""

from __future__ import annotations

import functools
import importlib.resources
from typing import Any

import grpc
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory


class ClientError(Exception):
    """A call failed. str() is for people. `reason` is for programs: the server's reason
    (proto/README.md, "Errors"), or the name of the status code, such as "UNAVAILABLE", if the
    server gave none."""

    def __init__(self, reason: str, message: str) -> None:
        super().__init__(f"{message} ({reason})")
        self.reason = reason
        self.message = message


# Refusals of Engage that time and more samples can cure.
PASSING = frozenset({"NOT_ARMED", "STREAM_TOO_YOUNG", "TOO_FEW_SAMPLES", "STREAM_STALE",
                     "DEVICE_STALE", "TRACKER_STALE", "NEVER_FREE", "OUTSIDE_WINDOW"})

_ANSWER_S = 5.0


def ask(call: Any, request: Any) -> Any:
    """One call that needs an answer."""
    try:
        return call(request, timeout=_ANSWER_S)
    except grpc.RpcError as error:
        raise to_error(error) from None


@functools.cache
def _types() -> dict[str, Any]:
    """google.rpc.Status and ErrorInfo, in their own pool: a program may have others of that
    name."""
    encoded = importlib.resources.files(__package__).joinpath("_details.bin").read_bytes()
    pool = descriptor_pool.DescriptorPool()
    for file in descriptor_pb2.FileDescriptorSet.FromString(encoded).file:
        pool.Add(file)
    factory = message_factory.MessageFactory(pool)
    return {name: factory.GetPrototype(pool.FindMessageTypeByName("google.rpc." + name))
            for name in ("Status", "ErrorInfo")}


def _reason(error: grpc.Call) -> str:
    for key, value in error.trailing_metadata() or ():
        if key != "grpc-status-details-bin":
            continue
        for detail in _types()["Status"].FromString(value).details:
            if detail.type_url.endswith("/google.rpc.ErrorInfo"):
                return str(_types()["ErrorInfo"].FromString(detail.value).reason)
    return str(error.code().name)


def to_error(error: grpc.RpcError) -> ClientError:
    """`error`: what a call of grpc raised; it is a grpc.Call as well."""
    return ClientError(_reason(error), error.details() or "no answer")
