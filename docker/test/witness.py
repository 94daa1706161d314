#!/usr/bin/env python3
"""Notes when this machine let a sleeper oversleep: evidence that a late client was the machine's doing.

    witness.py FILE

Sleeps 5 ms at a time until it is ended; every wake-up that came 20 ms late or more is a line of FILE, in ms.
"""

import sys
import time

NAP_S, LATE_S = 0.005, 0.020


def main() -> None:
    with open(sys.argv[1], "w", encoding="utf-8", buffering=1) as file:
        while True:
            begin = time.monotonic()
            time.sleep(NAP_S)
            late = time.monotonic() - begin - NAP_S
            if late >= LATE_S:
                file.write(f"{late * 1e3:.0f}\n")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
