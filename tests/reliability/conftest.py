"""Being here, it puts this folder's modules, and the samples of the readers' tests, within reach."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "plugins"))
