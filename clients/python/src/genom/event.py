"""Names for scripts of another client: ``from genom.event import GenoMError``."""

from .activity import Activity, Status
from .errors import GenoMError

__all__ = ["Activity", "GenoMError", "Status"]
