"""The browser of the tests that need a real one."""

import shutil

# The one without windows takes a third less of the processor for the same pages.
_NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
CHROMIUM = next(filter(None, map(shutil.which, _NAMES)), None)
"""Path of its program; None where there is none."""
