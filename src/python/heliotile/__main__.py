"""The program `heliotile`, as the wheel has it: `python -m heliotile run city.city.json --weather x.epw`."""

import sys

from ._heliotile import program


def main() -> int:
    """Runs the program with the words of the command line; its exit code."""
    return program(["heliotile", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
