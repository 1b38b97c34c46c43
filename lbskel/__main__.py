"""``python -m lbskel`` is the command line."""

from lbskel.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
