"""Server reflection and health, called with Debian's python3-grpcio. Debian has no packages
grpcio-reflection and grpcio-health-checking, so their few messages are described here, after the
public grpc/reflection/v1alpha and grpc/health/v1."""

import re
import sys

import grpc
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

from server_process import Server, argument, eventually

FIELD = descriptor_pb2.FieldDescriptorProto


def message(file, name, *fields):
    """fields: (name, number, type or message name, repeated?)"""
    described = file.message_type.add(name=name)
    for field, number, kind, *repeated in fields:
        entry = described.field.add(name=field, number=number)
        entry.label = FIELD.LABEL_REPEATED if repeated else FIELD.LABEL_OPTIONAL
        if isinstance(kind, str):
            entry.type, entry.type_name = FIELD.TYPE_MESSAGE, f".{file.package}.{kind}"
        else:
            entry.type = kind


def health_file():
    file = descriptor_pb2.FileDescriptorProto(name="health.proto", package="grpc.health.v1",
                                              syntax="proto3")
    message(file, "HealthCheckRequest", ("service", 1, FIELD.TYPE_STRING))
    # An enum and its number are the same on the wire: 1 is SERVING.
    message(file, "HealthCheckResponse", ("status", 1, FIELD.TYPE_INT32))
    return file


def reflection_file():
    file = descriptor_pb2.FileDescriptorProto(name="reflection.proto",
                                              package="grpc.reflection.v1alpha", syntax="proto3")
    message(file, "ServerReflectionRequest", ("host", 1, FIELD.TYPE_STRING),
            ("file_by_filename", 3, FIELD.TYPE_STRING),
            ("file_containing_symbol", 4, FIELD.TYPE_STRING),
            ("list_services", 7, FIELD.TYPE_STRING))
    message(file, "FileDescriptorResponse", ("file_descriptor_proto", 1, FIELD.TYPE_BYTES, True))
    message(file, "ServiceResponse", ("name", 1, FIELD.TYPE_STRING))
    message(file, "ListServiceResponse", ("service", 1, "ServiceResponse", True))
    message(file, "ErrorResponse", ("error_code", 1, FIELD.TYPE_INT32),
            ("error_message", 2, FIELD.TYPE_STRING))
    message(file, "ServerReflectionResponse",
            ("file_descriptor_response", 4, "FileDescriptorResponse"),
            ("list_services_response", 6, "ListServiceResponse"),
            ("error_response", 7, "ErrorResponse"))
    return file


class Types:
    """Message classes out of descriptors that came from anywhere."""

    def __init__(self):
        self.pool = descriptor_pool.DescriptorPool()

    def add(self, file):
        self.pool.Add(file)

    def __getitem__(self, name):
        descriptor = self.pool.FindMessageTypeByName(name)
        return message_factory.MessageFactory(self.pool).GetPrototype(descriptor)


def check_health(channel, types):
    response = types["grpc.health.v1.HealthCheckResponse"]
    check = channel.unary_unary("/grpc.health.v1.Health/Check",
                                request_serializer=lambda m: m.SerializeToString(),
                                response_deserializer=response.FromString)
    request = types["grpc.health.v1.HealthCheckRequest"]
    for service in ("", "finger"):
        eventually(lambda s=service: check(request(service=s), timeout=10).status == 1,
                   f"'{service}' is SERVING")
    try:
        check(request(service="no such device"), timeout=10)
        raise AssertionError("an unknown service is served")
    except grpc.RpcError as error:
        assert error.code() == grpc.StatusCode.NOT_FOUND, error


class Reflection:
    def __init__(self, channel, types):
        self.request = types["grpc.reflection.v1alpha.ServerReflectionRequest"]
        self.call = channel.stream_stream(
            "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
            request_serializer=lambda m: m.SerializeToString(),
            response_deserializer=types["grpc.reflection.v1alpha.ServerReflectionResponse"]
            .FromString)

    def ask(self, **question):
        answer = next(iter(self.call(iter([self.request(**question)]), timeout=10)))
        assert not answer.error_response.error_code, answer
        return answer

    def files_of(self, symbol):
        """The file that defines `symbol`, and all that it needs."""
        asked = self.ask(file_containing_symbol=symbol).file_descriptor_response
        found, waiting = {}, list(asked.file_descriptor_proto)
        while waiting:
            file = descriptor_pb2.FileDescriptorProto.FromString(waiting.pop())
            found[file.name] = file
            for name in file.dependency:
                if name not in found:
                    waiting += self.ask(
                        file_by_filename=name).file_descriptor_response.file_descriptor_proto
        return found


def calls_of_the_document(readme):
    with open(readme, encoding="utf-8") as file:
        section = file.read().split("\n## Calls\n")[1].split("\n\n")[0]
    return set(re.findall(r"^\| `(\w+)` \|", section, re.MULTILINE))


def add_in_order(types, files):
    added = set()

    def add(file):
        for name in file.dependency:
            if name not in added:
                add(files[name])
        if file.name not in added:
            types.add(file)
            added.add(file.name)

    for file in files.values():
        add(file)


def main(readme):
    types = Types()
    types.add(health_file())
    types.add(reflection_file())
    with Server(argument("HAPTICD")) as server:
        check_health(server.channel, types)
        reflection = Reflection(server.channel, types)
        answer = reflection.ask(list_services="*").list_services_response
        services = {s.name for s in answer.service}
        assert {"haptic.v1.HapticService", "grpc.health.v1.Health"} <= services, services
        files = reflection.files_of("haptic.v1.HapticService")
        methods = {m.name for file in files.values() for s in file.service for m in s.method
                   if s.name == "HapticService"}
        assert methods == calls_of_the_document(readme), methods
        # Nothing but what the server said of itself is needed to call it.
        add_in_order(types, files)
        call = server.channel.unary_unary(
            "/haptic.v1.HapticService/ListDevices",
            request_serializer=lambda m: m.SerializeToString(),
            response_deserializer=types["haptic.v1.ListDevicesResponse"].FromString)
        devices = call(types["haptic.v1.ListDevicesRequest"](), timeout=10).devices
        assert [device.name for device in devices] == ["finger"], devices
        assert [dof.actuated for dof in devices[0].dofs] == [True, False], devices
    print(f"{len(services)} services, {len(methods)} methods")


main(sys.argv[1])
