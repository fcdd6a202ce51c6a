"""The one error that wrong input raises, so that the command line can tell it from a defect of its own."""


class InputError(ValueError):
    """The input cannot be used as it is; the message names the file, what was found and what was expected."""


class NoTable(InputError):
    """The file holds no positions at all, such as a note or a picture beside tables."""
