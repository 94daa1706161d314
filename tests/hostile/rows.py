"""The one table of the rows of the attack suite."""

import dataclasses
from collections.abc import Callable

import boards
import certificates
import connections
import datagrams
import faults
import files
import grasps
import hosts
import http2
import inside
import inside_alone
import messages
import metrics
import neighbours
import outside
import recordings
import sessions
import signals
import streams
import web
import web_frames
from judge import GROWTH_MB


@dataclasses.dataclass(frozen=True)
class Row:
    name: str
    expected: str  # what must be, in words
    attack: Callable  # attack(daemon); attack(folder) if `alone`
    kind: str = ""  # of the kinds of bad input listed in README.md
    finding: str = ""  # of the findings listed there
    alone: bool = False  # runs daemons of its own, and judges them itself
    seconds: float = 30.0  # at most
    quiet: float = 1.5  # s of the block without the attack
    regains: bool = True  # force must be back afterwards
    causes: tuple = ()  # faults that the row causes on purpose
    grows: float = GROWTH_MB
    options: tuple = ()  # of hapticd
    server: str = ""  # fields of the scene's `server`
    web: bool = False  # browsers are served
    descriptors: int = 0  # RLIMIT_NOFILE of hapticd; 0: this host's
    term_under: bool = False  # SIGTERM comes while the attack goes on
    inside: bool = False  # the front has an attacker in it (inside.py)
    landlock: int | None = None  # version of Landlock that the kernel is to have; None: its own
    silent: bool = False  # its front may be taken for one that hangs
    user: int | None = None  # hapticd runs as this user
    must_fail: str = ""  # a positive control: the suite must say this


SERVED = "memory flat, served again within 1 s, force as promised"

ROWS = [
    Row("odd_headers", SERVED, http2.odd_headers, "1-4"),
    Row("odd_metadata", SERVED, http2.odd_metadata, "5"),
    Row("large_headers", SERVED, http2.large_headers, "6"),
    Row("exhaust_tcp", SERVED, connections.exhaust_tcp, "7", "1", descriptors=512,
        term_under=True),
    Row("exhaust_unix", SERVED, connections.exhaust_unix, "8", "1", descriptors=512),
    Row("silent_connections", "closed within 45 s", connections.silent, "9", seconds=60),
    Row("continuation_unacked", SERVED, http2.continuation_unacked, "10", "2"),
    Row("continuation_acked", SERVED, http2.continuation_acked, "11"),
    Row("empty_continuation", SERVED, http2.empty_continuation, "12"),
    Row("empty_data", SERVED, http2.empty_data, "13"),
    Row("ping_flood", SERVED, http2.ping_flood, "14"),
    Row("settings_flood", SERVED, http2.settings_flood, "15"),
    Row("hpack_bomb", SERVED, http2.hpack_bomb, "16"),
    Row("hpack_integers", SERVED, http2.hpack_integers, "17"),
    Row("hpack_table_size", SERVED, http2.hpack_table_size, "18"),
    Row("odd_frames", SERVED, http2.odd_frames, "19"),
    Row("other_protocols", SERVED, http2.other_protocols, "20"),
    Row("rapid_reset", SERVED, streams.rapid_reset, "21", "4", term_under=True),
    Row("indexed_reset", SERVED, streams.indexed_reset, "new", "4", term_under=True),
    Row("unread_answers", SERVED, streams.unread_answers, "new"),
    Row("reset_stops", "only what they name stops", streams.reset_stops, "21"),
    Row("streams_without_open", SERVED, streams.streams_without_open, "22", "3", term_under=True),
    Row("half_headers", SERVED, streams.half_headers, "22"),
    Row("gzip_one", SERVED, streams.gzip_one, "23", "5"),
    Row("gzip_many", SERVED, streams.gzip_many, "23", "5"),
    Row("reflection", "no thread per stream", streams.reflection, "24", "13"),
    Row("endless_calls", SERVED, streams.endless_calls, "24"),
    Row("process_limit", "serves, or refuses with a word", connections.process_limit, "25",
        alone=True, seconds=60),
    Row("few_descriptors", "serves, or refuses with a word", connections.few_descriptors, "54",
        "20", alone=True, seconds=90),
    Row("bad_opens", "none opens", messages.bad_opens, "26", seconds=120),
    Row("mutated_opens", SERVED, messages.mutated_opens, "27", seconds=60),
    Row("unknown_fields", SERVED, messages.unknown_fields, "27"),
    Row("wrong_caller", "NOT_CONTROLLER", messages.wrong_caller, "28"),
    Row("odd_stops", "answered, the finger is left alone", messages.odd_stops, "29",
        causes=("EMERGENCY_STOP",), regains=False),
    Row("bad_settings", "refused", messages.bad_settings, "30"),
    Row("bad_samples", "refused, counted", messages.bad_samples, "31"),
    Row("bad_trackers", "refused", messages.bad_trackers, "31"),
    Row("extremes", "force within its limits", messages.extremes, "32"),
    Row("sample_flood", SERVED, messages.sample_flood, "33"),
    Row("preemption", "force fades, and is back", sessions.preemption, "34"),
    Row("ten_operators", "one of ten", sessions.ten_operators, "35"),
    Row("theft", "refused", sessions.theft, "36"),
    Row("guessed_resume", "refused", sessions.guessed_resume, "37"),
    Row("six_resumes", "one of six", sessions.six_resumes, "38"),
    Row("resume_silent", "the lease ends at its time", sessions.resume_silent, "38"),
    Row("resume_while_engage_pends", "an Engage that was refused does not act",
        sessions.resume_while_engage_pends, "mutation"),
    Row("observers", "a controller finds a place", sessions.observers, "38", "12"),
    Row("former_controllers", "a controller finds a place", sessions.former_controllers, "new",
        "12"),
    Row("watches", SERVED, sessions.watches, "24"),
    Row("stops_and_clears", "answered, no force in a fault", sessions.stops_and_clears, "39",
        causes=("EMERGENCY_STOP",)),
    Row("clear_by_stranger", "answered", sessions.clear_by_stranger, "40"),
    Row("clock_jump", "force within its limits, gone when silent", sessions.clock_jump, "41"),
    Row("udp_replay", "accepted once", datagrams.replay, "42"),
    Row("udp_tampered", "dropped, unanswered", datagrams.tampered, "43"),
    Row("udp_lengths", "dropped, unanswered", datagrams.lengths, "44"),
    Row("udp_leaps", SERVED, datagrams.leaps, "45"),
    Row("udp_last_number", "counts stay true", datagrams.last_number, "45", "14-20"),
    Row("udp_rekey", "the session goes on", datagrams.rekey, "45"),
    Row("udp_ports", "only challenges", datagrams.ports, "45"),
    Row("udp_dead_keys", "unanswered", datagrams.dead_keys, "45"),
    Row("udp_junk", "unanswered", datagrams.junk, "45"),
    Row("udp_path_churn", SERVED, datagrams.path_churn, "45"),
    Row("stepped_clock", "the lease goes on", datagrams.stepped_clock, "45", "17", alone=True),
    Row("lying_cell", "fault and zero within 2 s", boards.lying_cell, "47", "6", alone=True,
        seconds=150),
    Row("honest_cell", "no fault", boards.honest_cell, "47", "6", alone=True, seconds=120),
    Row("board_text", "calls work, the log is clean", boards.bad_text, "47", "11", alone=True,
        seconds=90),
    Row("board_openings", "never armed", boards.bad_openings, "46", "16", alone=True, seconds=150),
    Row("board_states", "no step of force", boards.bad_states, "47", alone=True, seconds=180),
    Row("board_arms_itself", "the fault stays", boards.arms_by_itself, "47", alone=True,
        seconds=60),
    Row("board_arms_twice", "a nonce per arming, only the newest counts", boards.arms_twice,
        "mutation", alone=True, seconds=60),
    Row("metrics_line", SERVED, metrics.endless_line, "55", "7"),
    Row("metrics_header", SERVED, metrics.endless_header, "55", "7"),
    Row("metrics_headers", SERVED, metrics.many_headers, "55", "7"),
    Row("metrics_chunks", SERVED, metrics.chunked_post, "55", "7"),
    Row("metrics_body", SERVED, metrics.long_body, "55", "7"),
    Row("metrics_slow", "others are scraped, SIGTERM in 5 s", metrics.slow_bytes, "55", "8",
        term_under=True),
    Row("metrics_unread", "others are scraped", metrics.unread, "55", term_under=True),
    Row("metrics_ranges", "no more than the page", metrics.ranges, "55", "14-20"),
    Row("metrics_idle", "others are scraped", metrics.idle, "55"),
    Row("metrics_odd", SERVED, metrics.odd_requests, "55"),
    Row("web_idle", SERVED, web.idle, "new", web=True),
    Row("web_left_behind", "no connection stays open", web.left_behind, "new", web=True),
    Row("web_slow", "none lasts, others are served, SIGTERM in 5 s", web.slow, "new", web=True,
        seconds=60, term_under=True),
    Row("web_headers", SERVED, web.headers, "new", web=True),
    Row("web_bodies", SERVED, web.bodies, "new", web=True),
    Row("web_pipelined", SERVED, web.pipelined, "new", web=True),
    Row("web_smuggled", "no request in another's body", web.smuggled, "new", web=True),
    Row("web_upgrades", SERVED, web_frames.upgrades, "new", web=True, term_under=True),
    Row("web_frames", SERVED, web_frames.odd_frames, "new", web=True),
    Row("web_fragments", SERVED, web_frames.fragments, "new", web=True),
    Row("web_pings", SERVED, web_frames.pings, "new", web=True),
    Row("web_json", "refused or ignored, and quickly", web_frames.json_bombs, "new", web=True,
        seconds=60),
    Row("web_unread_states", SERVED, web_frames.unread_states, "new", web=True, term_under=True),
    Row("web_tokens", "none is guessed", web.wrong_tokens, "new", web=True),
    Row("web_unread_pages", SERVED, web.unread_pages, "new", web=True, term_under=True),
    Row("web_stops", "only what they name stops", web.stops, "new", web=True),
    Row("web_strangers", "refused, the log is clean", web.strangers, "new", web=True),
    Row("web_handshakes", "each ends, others are served", web.slow_handshakes, "new", alone=True,
        seconds=60),
    Row("web_sigterm", "ends within 5 s, sessions hear why", web.many_at_sigterm, "new",
        alone=True, seconds=60),
    Row("log_text", "the log is clean", signals.log_text, "29", "14", alone=True, seconds=60),
    Row("replay_files", "refused, or played", files.replays, "48", alone=True, seconds=120),
    Row("replay_span", "refused, or played", files.replay_span, "48", "15", alone=True, seconds=60),
    Row("bad_scenes", "refused by name", files.scenes, "49", alone=True, seconds=120),
    Row("big_scenes", "refused within 5 s and 100 MB", files.big_scenes, "49", "18", alone=True),
    Row("addresses", "refused by name", files.addresses, "50", alone=True, seconds=90),
    Row("tls_peers", "refused", certificates.tls_peers, "51", alone=True, seconds=90),
    Row("key_mode", "refused, or said", certificates.key_mode, "51", "14-20", alone=True),
    Row("record_restart", "nothing is overwritten", recordings.record_restart, "54", "9",
        alone=True),
    Row("record_two", "a file each, or refused", recordings.record_two, "54", "9", alone=True),
    Row("record_symlink", "no link is followed", recordings.record_symlink, "54", "9", alone=True,
        seconds=90),
    Row("file_size_limit", "ends at a whole row, hapticd goes on", recordings.file_size_limit, "54",
        "10", alone=True),
    Row("full_disk", "ends at a whole row, hapticd goes on", recordings.full_disk, "54", "19",
        alone=True),
    Row("record_flush", "lacks 0.3 s at most", recordings.record_flush, "54", "19", alone=True),
    Row("sigterm", "ends within 5 s", signals.sigterm, "52", alone=True, seconds=150),
    Row("many_signals", "nothing, then the end", signals.many_signals, "53", alone=True,
        seconds=60),
    Row("sigstop", "force fades, served again", signals.sigstop, "53", alone=True),
    Row("taken_ports", "refused with a word", signals.taken_ports, "54", alone=True, seconds=60),
    Row("stale_socket", "served; a plain file stays", signals.stale_socket, "54", alone=True,
        seconds=60),
    Row("closed_stdio", "served, recordings whole", signals.closed_stdio, "54", alone=True,
        seconds=60),
    Row("start_inside", "no force until it was free, or with planes", grasps.start_inside, "new"),
    Row("start_orders", "force in the end", grasps.start_orders, "new", alone=True, seconds=300),
    Row("killed_in_phases", "force fades, and is back", grasps.killed_in_phases, "new", alone=True,
        seconds=240),
    Row("front_killed", "served in 1 s, sessions resume", faults.killed, "front"),
    Row("front_frozen", "replaced within 3.5 s", faults.frozen, "front", silent=True),
    Row("front_stutters", "kept", faults.stuttering, "front"),
    Row("control_deaf", "the suite sees it", faults.deaf, "control",
        must_fail="fault LOOP_LATE"),
    Row("control_fault", "the suite sees it", faults.stopped_by_hand, "control",
        must_fail="fault EMERGENCY_STOP", regains=False),
]
ROWS += [Row("front_" + mode.name, mode.expected, mode, "front", mode.finding, inside=True,
             landlock=mode.landlock, **mode.more) for mode in inside.MODES]
ROWS.append(Row("front_several", inside.SURVIVED, inside.several, "front", "F1-F16", inside=True,
                quiet=5.0))
ROWS += [Row("front_" + name, expected, attack, "front", finding, alone=True, seconds=120)
         for name, finding, expected, attack in inside_alone.ALONE]
ROWS += [Row(name, expected, attack, "outside", **more) for name, expected, attack, more in
         (*outside.ROWS, *neighbours.ROWS, *hosts.ROWS)]
