"""What stops an archive, beside an input that cannot be read."""

from ..io.errors import InputError


class Stopped(InputError):
    """Something that holds for the whole archive is wrong, so that no file may be skipped for it."""
