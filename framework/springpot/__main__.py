"""``python -m springpot`` is the command ``springpot``."""

import sys

try:
    from springpot.cli import main

    main()
except KeyboardInterrupt:
    sys.exit(130)
