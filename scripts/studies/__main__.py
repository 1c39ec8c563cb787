"""Runs the study that is named: `python -m studies NAME [options]`, as scripts/study does."""

import importlib
import sys

from .program import Failed

name = sys.argv.pop(1)
try:
    sys.exit(importlib.import_module(f".{name.replace('-', '_')}", __package__).main())
except Failed as failed:
    sys.exit(f"{name}: error: {failed}")
