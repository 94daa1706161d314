"""Where the datagrams of the UDP path go: names and addresses of both families."""

import socket
import unittest
from unittest import mock

from haptic._udp import addresses, connect, host_of


def found(*sockets: socket.socket) -> list[tuple]:
    """What getaddrinfo returns for a name at these addresses."""
    return [(socket.AF_INET, socket.SOCK_DGRAM, 0, "", far.getsockname()) for far in sockets]


def listener(family: socket.AddressFamily, address: str) -> socket.socket:
    made = socket.socket(family, socket.SOCK_DGRAM)
    made.settimeout(10)
    made.bind((address, 0))
    return made


class Connect(unittest.TestCase):
    def reaches(self, family: socket.AddressFamily, address: str, host: str) -> None:
        with listener(family, address) as far:
            with connect(addresses(host, far.getsockname()[1])) as near:
                self.assertEqual(near.family, family)
                near.send(b"here")
                self.assertEqual(far.recv(16), b"here")

    def test_an_ipv4_address(self) -> None:
        self.reaches(socket.AF_INET, "127.0.0.1", "127.0.0.1")

    def test_an_ipv6_address(self) -> None:
        try:
            listener(socket.AF_INET6, "::1").close()
        except OSError as error:
            self.skipTest(f"no IPv6 here: {error}")
        self.reaches(socket.AF_INET6, "::1", "::1")

    def test_a_name(self) -> None:
        with listener(socket.AF_INET, "127.0.0.1") as far, mock.patch(
                "socket.getaddrinfo", return_value=found(far)) as asked:
            with connect(addresses("robot.example", 29471)) as near:
                near.send(b"here")
                self.assertEqual(far.recv(16), b"here")
            self.assertEqual(asked.call_args.args, ("robot.example", 29471))

    def test_an_unreachable_address_is_skipped(self) -> None:
        with listener(socket.AF_INET, "127.0.0.1") as far, mock.patch(
                "socket.getaddrinfo",
                return_value=[(socket.AF_INET, socket.SOCK_DGRAM, 0, "", ("255.255.255.255", 9)),
                              *found(far)]):
            # The first is refused: a broadcast without SO_BROADCAST.
            with connect(addresses("robot.example", 29471)) as near:
                self.assertEqual(near.getpeername(), far.getsockname())

    def test_each_turn_begins_at_another_address(self) -> None:
        with (listener(socket.AF_INET, "127.0.0.1") as a,
              listener(socket.AF_INET, "127.0.0.1") as b,
              mock.patch("socket.getaddrinfo", return_value=found(a, b))):
            for turn, far in enumerate((a, b, a)):
                with connect(addresses("robot.example", 29471), turn) as near:
                    self.assertEqual(near.getpeername(), far.getsockname())

    def test_no_address_is_an_oserror(self) -> None:
        with mock.patch("socket.getaddrinfo", return_value=[]):
            with self.assertRaisesRegex(OSError, "robot.example has no address"):
                connect(addresses("robot.example", 29471))
        with mock.patch("socket.getaddrinfo", side_effect=socket.gaierror(-2, "unknown")):
            with self.assertRaises(OSError):
                connect(addresses("robot.example", 29471))


class HostOf(unittest.TestCase):
    def test_the_streams_host_without_port(self) -> None:
        self.assertEqual(host_of("robot.example:29470"), "robot.example")
        self.assertEqual(host_of("[::1]:29470"), "::1")
        for resolver in ("dns:", "dns:///", "dns://192.0.2.53/"):
            self.assertEqual(host_of(resolver + "robot.example:29470"), "robot.example")
        self.assertEqual(host_of("ipv6:[::1]:29470"), "::1")
        self.assertEqual(host_of("192.0.2.7:29470"), "192.0.2.7")

    def test_loopback_for_a_unix_socket(self) -> None:
        self.assertEqual(host_of("unix:/run/hapticd/socket"), "127.0.0.1")


if __name__ == "__main__":
    unittest.main()
