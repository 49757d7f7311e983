"""The one exception that a user's mistake raises."""


class InputError(Exception):
    """Input that cannot be used: file, key and value, and what to do about it, in one line.

    The command line prints the message alone and exits with code 2; nodes log it and exit likewise.
    """
