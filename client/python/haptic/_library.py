"""libhaptic: found, loaded and called. Everything else in the package goes through here."""

from __future__ import annotations

import atexit
import os
import pathlib
import threading
import weakref
from collections.abc import Callable, Iterable
from typing import Any, Self

from ._version import __version__

try:
    from ._libhaptic import ffi as ffi
except ModuleNotFoundError as missing:
    raise ImportError("haptic needs cffi: install the package python3-cffi-backend "
                      f"({missing})") from None

_NAME = "libhaptic.so.0"


def _load() -> Any:
    """The library beside this package in a build or below a prefix, or else the system's."""
    here = pathlib.Path(__file__).resolve().parent
    near = (here.parents[1] / "c" / _NAME, here.parents[2] / _NAME)
    found = next((str(place) for place in near if place.exists()), _NAME)
    try:
        library = ffi.dlopen(found)
    except OSError as error:
        raise ImportError(f"haptic {__version__} needs the C library: install the package "
                          f"libhaptic0 {__version__} ({error})") from None
    version = ffi.string(library.haptic_version()).decode()
    if version != __version__:
        raise ImportError(f"haptic {__version__} needs libhaptic0 {__version__}, but {found} is "
                          f"{version}: install the same version of both")
    return library


lib: Any = _load()
_REASONS = {getattr(lib, name): name.removeprefix("HAPTIC_ERROR_") for name in dir(lib)
            if name.startswith("HAPTIC_ERROR_")}


class ClientError(Exception):
    """A call failed. str() is for people. `reason` is for programs: the server's reason
    (proto/README.md, "Errors") such as "LEASE_HELD", or if it gave none UNREACHABLE, TIMEOUT,
    CLOSED, INVALID_ARGUMENT, NOT_READY, PERMISSION_DENIED, NO_SUCH_DEVICE or PROTOCOL."""

    def __init__(self, reason: str, message: str) -> None:
        super().__init__(reason, message)  # so that it can be pickled
        self.reason = reason
        self.message = message

    def __str__(self) -> str:
        return f"{self.message} ({self.reason})"


# Values and structs.


def new(struct: str) -> Any:
    """A struct of C that knows its size; the rest is 0."""
    made = ffi.new(struct + " *")
    made.size = ffi.sizeof(struct)
    return made


def floats(values: Iterable[float], count: int | None = None, name: str = "") -> tuple[float, ...]:
    """Of any sequence of numbers, arrays of numpy too. Raises ValueError if there are not
    `count`."""
    given = tuple(map(float, values))
    if count is not None and len(given) != count:
        raise ValueError(f"{name}: has {len(given)} values, must have {count}")
    return given


def doubles(values: Iterable[float], count: int | None = None, name: str = "") -> Any:
    """The same as an array of C."""
    return ffi.new("double[]", floats(values, count, name))


def chars(value: str, name: str) -> bytes:
    """Text for C, which would end at a character 0. Raises ValueError if there is one."""
    if "\0" in value:
        raise ValueError(f"{name}: {value!r}, must be text without a character 0")
    return value.encode()


def lists(array: Any, count: int) -> tuple[Any, ...]:
    """The first `count` values of an array of C."""
    return tuple(ffi.unpack(array, count)) if count > 0 else ()


def put(array: Any, values: tuple[float, ...], name: str) -> int:
    """Into the beginning of an array of C; returns how many. Raises ValueError if they do not
    fit."""
    if len(values) > len(array):
        raise ValueError(f"{name}: has {len(values)} values, must have at most {len(array)}")
    array[0:len(values)] = values
    return len(values)


def text(array: Any) -> str:
    """Replaces what is no UTF-8, which another server may send."""
    return str(ffi.string(array).decode(errors="replace"))


def name_of(names: dict[int, str], value: int) -> str:
    """The number itself, if only a newer server knows it."""
    return names.get(value, str(value))


# Calls.


def _answer(function: Callable[..., int], *arguments: Any) -> tuple[int, ClientError | None]:
    """Calls a function of haptic.h, whose last argument is the error."""
    error = new("haptic_error")
    code = function(*arguments, error)
    if code >= 0:
        return code, None
    reason = text(error.server_reason)
    return code, ClientError(reason if reason != "" else _REASONS[code], text(error.message))


def call(function: Callable[..., int], *arguments: Any) -> int:
    """Returns at once, or after a short time. Raises ClientError."""
    code, failed = _answer(function, *arguments)
    if failed is not None:
        if ending and threading.current_thread() is not threading.main_thread():
            raise SystemExit  # its session was closed by _end(): a traceback says nothing new
        raise failed
    return code


def refusal(function: Callable[..., int], *arguments: Any) -> ClientError | None:
    """The error of a function that answers by it."""
    return _answer(function, *arguments)[1]


def compute(function: Callable[..., int], *arguments: Any) -> None:
    """Calls a function that needs no server. Raises ValueError."""
    failed = refusal(function, *arguments)
    if failed is not None:
        raise ValueError(failed.message)


def ask(function: Callable[..., int], *arguments: Any,
        undo: Callable[[], object] = lambda: None) -> None:
    """Calls a function that waits for the server. The main thread leaves that to another one, so
    that Ctrl-C ends the wait; `undo` then takes back what may still come of the call."""
    if ending or threading.current_thread() is not threading.main_thread():
        call(function, *arguments)
        return
    lock, done = threading.Lock(), threading.Event()
    failed: BaseException | None = None
    left = False

    def work() -> None:
        nonlocal failed
        try:
            failed = refusal(function, *arguments)
        except BaseException as error:  # an argument that C cannot hold: the caller's to hear
            failed = error
        with lock:
            done.set()
            if left:
                undo()

    thread = threading.Thread(target=work, name="haptic call", daemon=True)
    try:
        thread.start()
        done.wait()
    except BaseException:
        with lock:
            left = True
            if done.is_set():
                undo()
        raise
    if failed is not None:
        raise failed


# Handles, and the end.

ending = False  # Python ends
_open: weakref.WeakSet[Handle] = weakref.WeakSet()


class Handle:
    """A handle of the library, closed when nothing refers to it any more. After a fork only the
    parent has it: in the child every call raises CLOSED."""

    def __init__(self, c: Any, close: Callable[[Any], int]) -> None:
        self._c = ffi.gc(c, close)
        self._close, self._process = close, os.getpid()
        _open.add(self)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if os.getpid() == self._process:
            self._close(self._c)

    def close(self) -> None:
        """Ends it: a session's force fades out, and its lease ends. Idempotent."""
        if os.getpid() != self._process:
            raise ClientError("CLOSED", f"this process was forked from process {self._process}, "
                              "which has the connections: it goes on with them")
        self._close(self._c)


@atexit.register
def _end() -> None:
    """Closes what is open while threads that wait in the library can still return to Python."""
    global ending
    ending = True
    for handle in list(_open):
        handle.__exit__()
