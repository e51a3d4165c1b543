"""``python -m atlasphys`` is the command ``atlasphys``."""

import sys

from atlasphys.cli import main

if __name__ == "__main__":
    sys.exit(main())
