"""``python -m skpose`` is the command ``skpose``."""

import sys

from skpose._cli.main import main

if __name__ == "__main__":
    sys.exit(main())
