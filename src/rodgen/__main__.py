"""The `rodgen` command, as `python -m rodgen`."""

from rodgen.cli import main

if __name__ == "__main__":
    main()
