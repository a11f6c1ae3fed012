"""What can be wrong with a film."""


class FilmError(Exception):
    """What is wrong with a film, in one line."""


class MissingImage(FilmError):
    """A film goes on without this image, which the film had when it was taken."""
