"""The program `heliotile` of the wheel: `python -m heliotile run city.city.json --weather
x.epw`."""

import sys

from ._heliotile import program


def main() -> int:
    """Runs the program with the arguments of the command line. Returns its exit code."""
    return program(["heliotile", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
