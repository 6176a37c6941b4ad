"""Names where scripts for another client look for them: ``from genom.event import GenoMError``."""

from .activity import Activity, Status
from .errors import GenoMError

__all__ = ["Activity", "GenoMError", "Status"]
