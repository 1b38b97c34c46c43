"""``python -m lbskel`` is the command line."""

from lbskel.cli.main import main

if __name__ == "__main__":
    raise SystemExit(main())
