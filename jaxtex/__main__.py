"""`python -m jaxtex`: the same as the command `jaxtex`."""

from jaxtex.cli.main import main

if __name__ == "__main__":
    raise SystemExit(main())
