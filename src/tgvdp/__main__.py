"""``python -m tgvdp`` and the console command ``tgvdp``."""

import sys

from tgvdp.cli import main

if __name__ == "__main__":
    sys.exit(main())
