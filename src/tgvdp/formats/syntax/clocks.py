"""Times of day and dates as people write them."""

import datetime
import re

from tgvdp.errors import InputError
from tgvdp.formats.syntax.reading import shown

#: Seconds of a day, after which times of day begin anew; who goes back by more than half of it is past midnight.
DAY_S = 86_400.0
#: Two or three numbers; spreadsheets show what is beyond a day with the days before it.
_CLOCK = re.compile(r"(?:(\d+) days?, )?(?:(\d+):)?(\d{1,2}):(\d{1,2}(?:\.\d*)?)")
#: A date as it is written in much of Europe; month and day cannot be told apart where slashes stand between.
_POINTED_DATE = re.compile(r"(\d{1,2})\.(\d{1,2})\.(\d{4})[ T]+(.*)")


def is_time_of_day(text: str) -> bool:
    """Whether a text is a time of day without a date, after which midnight may come."""
    return _CLOCK.fullmatch(text.replace(",", ".")) is not None


def clock_s(text: str, *, with_hours: bool = False) -> float:
    """Seconds of a time of day, or of a date with a time.

    Parameters
    ----------
    text : str
        As in 10:05:30, 2026-01-02T10:05:30Z or 2.1.2026 10:05.
    with_hours : bool
        Whether two numbers are hours and minutes, and not minutes and seconds.

    Raises
    ------
    InputError
        When it is neither.
    """
    if match := _CLOCK.fullmatch(text.replace(",", ".")):
        days, hours, minutes, seconds = match.groups()
        if hours is None and with_hours:
            hours, minutes, seconds = minutes, seconds, "0"
        if float(seconds) >= 60.0 or (hours is not None and float(minutes) >= 60.0):
            raise InputError(f"minutes after hours and seconds must be below 60, got {shown(text)}")
        return DAY_S * float(days or 0) + 3600.0 * float(hours or 0) + 60.0 * float(minutes) + float(seconds)
    plain = text.removesuffix("UTC").rstrip()
    if match := _POINTED_DATE.fullmatch(plain):
        day, month, year, clock = match.groups()
        plain = f"{year}-{month:0>2}-{day:0>2} {clock}"
    try:
        moment = datetime.datetime.fromisoformat(plain)
    except ValueError:
        raise InputError(f"must be seconds, h:min:s or a date with a time, got {shown(text)}") from None
    # Without a zone clocks go on evenly, whatever the zone of this machine does in that night.
    return (moment if moment.tzinfo else moment.replace(tzinfo=datetime.UTC)).timestamp()
