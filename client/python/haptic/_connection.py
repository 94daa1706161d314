"""A connection to hapticd: facts about the server and its devices, sessions, emergency stop."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ._facts import Device, ServerInfo
from ._library import ClientError, Handle, ask, call, chars, ffi, lib, new, text
from ._messages import DeviceState
from ._ports import DEFAULT_SERVER
from ._session import Session
from ._types import Carriers, Event, Priority, Tls

_MOST_NAMES = 65536  # bytes


class Connection(Handle):
    """A connection to "host:port" or "unix:/path". Does not wait for the server. A call that needs
    an answer raises ClientError if none comes within 5 s. Every method may be called from any
    thread. Sessions outlive their connection."""

    def __init__(self, address: str = DEFAULT_SERVER, *, tls: Tls | None = None) -> None:
        """Without `tls` hapticd takes only programs on its own host."""
        options, made = new("haptic_connect_options"), ffi.new("haptic_connection **")
        kept = [ffi.new("char[]", chars(address, "address"))]
        options.address = kept[0]
        if tls is not None:
            options.tls = 1
            for name in ("ca_file", "certificate_file", "key_file", "server_name"):
                if getattr(tls, name) != "":
                    kept.append(ffi.new("char[]", chars(str(getattr(tls, name)), name)))
                    setattr(options, name, kept[-1])
        call(lib.haptic_connect, options, made)
        super().__init__(made[0], lib.haptic_disconnect)

    def server_info(self) -> ServerInfo:
        info = new("haptic_server_info")
        ask(lib.haptic_server, self._c, info)
        return ServerInfo.of(info)

    def healthy(self, device: str = "") -> bool:
        """Whether the device, or every one, is open and the 1 kHz loop is on time."""
        answer = ffi.new("int32_t *")
        ask(lib.haptic_health, self._c, chars(device, "device"), answer)
        return bool(answer[0] == 1)

    def devices(self) -> list[Device]:
        found, count = ffi.new("haptic_device[]", 1), ffi.new("size_t *", 1)
        while True:
            found[0].size = ffi.sizeof("haptic_device")
            ask(lib.haptic_devices, self._c, found, len(found), count)
            if count[0] <= len(found):
                return [Device.of(found[i]) for i in range(count[0])]
            found = ffi.new("haptic_device[]", count[0])

    def session(self, *, client_name: str, nominal_rate_hz: float, device: str = "",
                observer: bool = False, tracker: bool = False, state_rate_hz: float | None = None,
                priority: Priority = Priority.PRIMARY, carriers: Carriers = Carriers.BEST,
                reconnect: bool = False, re_engage: bool = False, derive_planes: bool = False,
                blocks: Iterable[tuple[int, int]] = (), fresh_end_s: float = 0.0,
                hold_end_s: float = 0.0, fade_end_s: float = 0.0, timeout: float = 5.0) -> Session:
        """Opens a session and waits until the server agrees. Close it, or use it in `with`. States
        come at `state_rate_hz`; None: at the nominal rate; 0: every tick, which is much for Python.

        An `observer` only receives; a `tracker` publishes poses of the palm that carries the device
        (publish_pose()). A session is not both.

        `reconnect`: a lost stream is opened again and the session resumed, with its force if that
        is soon enough. `re_engage`: force is asked for again after it was lost, never after a
        fault. `derive_planes`: a held proxy is sent as contacts, one per block (first coordinate,
        how many) of `blocks`; none: all coordinates are one. The ends are ages at which a sample
        stops being fresh, its force begins to fade, and is zero: each can shorten the scene's
        limit; 0: it is the scene's. `timeout`: s, of each call that waits for the server."""
        if nominal_rate_hz == 0:  # C takes it for its default
            raise ValueError("nominal_rate_hz: 0, must be 1 to 2000")
        options, made = new("haptic_session_options"), ffi.new("haptic_session **")
        kept = (ffi.new("char[]", chars(device, "device")),
                ffi.new("char[]", chars(client_name, "client_name")))
        options.device, options.client_name = kept
        options.observer, options.tracker = observer, tracker
        options.priority, options.carriers = priority, carriers
        options.nominal_rate_hz = nominal_rate_hz
        options.state_rate_hz = nominal_rate_hz if state_rate_hz is None else state_rate_hz
        options.reconnect, options.re_engage = reconnect, re_engage
        options.derive_planes, options.timeout_ms = derive_planes, max(1, round(timeout * 1e3))
        pairs = ffi.new("haptic_block[]", [tuple(map(int, block)) for block in blocks])
        options.blocks, options.block_count = pairs, len(pairs)
        options.fresh_end_ns, options.hold_end_ns, options.fade_end_ns = (
            round(end * 1e9) for end in (fresh_end_s, hold_end_s, fade_end_s))
        ask(lib.haptic_open, self._c, options, made,
            undo=lambda: lib.haptic_close(made[0]))
        return Session(made[0])

    def watch(self, device: str = "", rate_hz: float = 30.0) -> Iterator[DeviceState | Event]:
        """States and events of a device, the newest of each, until the server ends or the iterator
        is closed: those of an observer."""
        with self.session(client_name="watch", nominal_rate_hz=rate_hz, device=device,
                          observer=True) as session:
            while True:
                yield from session.events()
                try:
                    yield session.wait_for_state(0.1)
                except ClientError as error:
                    if error.reason != "TIMEOUT":
                        raise

    def emergency_stop(self, device: str = "", reason: str = "") -> list[str]:
        """Stops `device`, or all devices if it is empty; needs no session. Returns the devices that
        are in FAULT now."""
        names = ffi.new("char[]", _MOST_NAMES)
        ask(lib.haptic_emergency_stop, self._c, chars(device, "device"),
            reason.replace("\0", " ").encode(errors="replace"), names, _MOST_NAMES)
        return text(names).splitlines()

    def clear_fault(self, device: str = "", faults: Iterable[int] = ()) -> list[int]:
        """Clears faults by number; none: all that are active. Returns what was cleared. Raises
        FAULT_PERSISTS if a cause persists."""
        cleared, bits = ffi.new("uint32_t *"), 0
        for fault in faults:
            bits |= 1 << int(fault)
        ask(lib.haptic_clear_fault, self._c, chars(device, "device"), bits, cleared)
        return [bit for bit in range(32) if cleared[0] >> bit & 1 == 1]
