"""``python -m springpot`` is the command ``springpot``."""

from springpot.cli import main

main()
