"""The filters, one method per file."""

from .imm import IMM
from .kalman import Kalman

__all__ = ["IMM", "Kalman"]
