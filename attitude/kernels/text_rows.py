"""Rows of text: dates and numbers to bytes, and bytes to integers and doubles.

A text is (n,) bytes.  Days are modified Julian days; `atto` is 1e-18 s.
"""

import numpy as np

from .decimals import TEN_TO, put_number, spread, take_digits, take_number
from .intrinsics import inlined, kernel, load, routine, store
from .layout import LEAD_DATE, LEAD_NOTHING, LEAD_WORD

U = np.uint64
BYTE = np.uint8
TAB, NEWLINE, RETURN, BLANK, POINT, COLON, LARGE_T, LARGE_Z = 9, 10, 13, 32, 46, 58, 84, 90
DAY = 86400  # s
LONGEST_DAY = 86401  # s: what a number that grows with date and time of day counts to a day
BILLION = 1_000_000_000
MOST_SECONDS = 1e12  # ten thousand years are less
TO_MARCH = 678881  # days from the first of March of year 0 to modified Julian day 0
MOST_DECIMALS = 18
NEWLINES = U(0x0A0A0A0A0A0A0A0A)
LOW_BITS = U(0x7F7F7F7F7F7F7F7F)
DIGITS = U(0x3030303030303030)
NO_DIGITS = U(2**64 - 1)
NO_DAY = -(2**40)


# -- out --------------------------------------------------------------------------------------------


@kernel
def put_rows(leads, width, columns, first, last, pieces, ends, text, found):
    """Write rows first to last, excluded: piece, lead, piece, number, piece, number, ..., piece.

    leads : (n width,) bytes; columns : (c, n); pieces : bytes of the c + 2 of them in a row
    ends : (c + 2,), where each ends; text : written, with room for
        (last - first) (width + c WIDEST_NUMBER + all pieces) bytes and TEXT_MARGIN more
    found : (1,), written: how many bytes, or -1 - i where row i holds a number that is not finite
    """
    place = 0
    for i in range(first, last):
        place = _put_piece(text, place, pieces, 0, ends[0])
        place = _put_piece(text, place, leads, width * i, width * (i + 1))
        place = _put_piece(text, place, pieces, ends[0], ends[1])
        for j in range(columns.shape[0]):
            value = columns[j, i]
            if not abs(value) < np.inf:
                found[0] = -1 - i
                return
            place = put_number(text, place, value)
            place = _put_piece(text, place, pieces, ends[j + 1], ends[j + 2])
    found[0] = place


@inlined
def _put_piece(text, place, piece, first, last):
    """Copy from first to last, by words as far as there are whole ones."""
    while first + 8 <= last:
        store(text, place, load(piece, first, U(0)))
        place += 8
        first += 8
    while first < last:
        store(text, place, load(piece, first, BYTE(0)))
        place += 1
        first += 1
    return place


@kernel
def put_dates(seconds, rest, day, nanosecond, below, begins, offsets, dates, found):
    """Instants as text to the nanosecond, 2016-12-31T23:59:60.123456789.

    seconds, rest : (n,), since a day and nanosecond of it, and `below`, a part of one
    begins, offsets : (k,), whole numbers, of UTC: the days at whose beginnings TAI - UTC changed, and what it
        is since, s; seconds count from a day of TAI then.  Empty for a scale without leaps.
    dates : (29 n,) bytes, written
    found : (1,), written: 0, or 1 where an instant is before the first of `begins` or in no year 0 to 9999
    """
    found[0] = 1
    at, date = np.int64(0), np.int64(-(2**62))
    year_month = month_day = U(0)
    for i in range(seconds.shape[0]):
        if not abs(seconds[i]) < MOST_SECONDS:
            return
        whole = np.int64(np.floor(seconds[i]))
        nano = np.int64(np.rint((seconds[i] - float(whole)) * 1e9 + (rest[i] * 1e9 + below))) + nanosecond
        carried = nano // BILLION
        nano -= carried * BILLION
        at, mjd, clock = _date_and_clock(whole + carried + day * DAY, at, begins, offsets)
        if at < 0:
            return
        if mjd != date:
            date = mjd
            year, month, of_month = _calendar(mjd)
            if not 0 <= year <= 9999:
                return
            year_month = _two_digits(year // 100) | _two_digits(year % 100) << U(16) | U(45) << U(32)
            year_month |= _two_digits(month) << U(40) | U(45) << U(56)
            month_day = _two_digits(of_month) | U(LARGE_T) << U(16)
        _put_clock(dates, 29 * i, year_month, month_day, clock, nano)
    found[0] = 0


@inlined
def _put_clock(dates, place, year_month, day, clock, nano):
    minutes = min(clock // 60, 1439)  # a leap second belongs to the last minute
    hour = minutes // 60
    first = nano // 100_000_000
    store(dates, place, year_month)
    word = day | _two_digits(hour) << U(24) | U(COLON) << U(40) | _two_digits(minutes - 60 * hour) << U(48)
    store(dates, place + 8, word)
    word = U(COLON) | _two_digits(clock - 60 * minutes) << U(8) | U(POINT) << U(24)
    store(dates, place + 16, word | U(48 + first) << U(32))
    store(dates, place + 21, spread(U(nano - first * 100_000_000)) | DIGITS)


@inlined
def _two_digits(value):
    return U(48 + value // 10) | U(48 + value % 10) << U(8)


@routine
def _date_and_clock(second, at, begins, offsets):
    """(at, day, second of it) of a whole second since day 0; `at` is an entry of begins, -1 before all."""
    last = begins.shape[0] - 1
    if last < 0:
        day = second // DAY
        return at, day, second - day * DAY
    while at < last and second >= begins[at + 1] * DAY + offsets[at + 1]:
        at += 1
    while at >= 0 and second < begins[at] * DAY + offsets[at]:
        at -= 1
    if at < 0:
        return at, second, second
    second -= offsets[at]
    day = second // DAY
    if at < last and day >= begins[at + 1]:  # 23:59:60
        return at, day - 1, second - (day - 1) * DAY
    return at, day, second - day * DAY


@routine
def _calendar(mjd):
    """(year, month, day of month), Gregorian; counted from the first of March of year 0."""
    days = mjd + TO_MARCH
    cycle = days // 146097
    days -= 146097 * cycle
    century = min(days // 36524, 3)
    days -= 36524 * century
    fours = days // 1461
    days -= 1461 * fours
    years = min(days // 365, 3)
    days -= 365 * years
    month = (5 * days + 2) // 153
    year = 400 * cycle + 100 * century + 4 * fours + years
    day = days - (153 * month + 2) // 5 + 1
    return (year, month + 3, day) if month < 10 else (year + 1, month - 9, day)


# -- in ---------------------------------------------------------------------------------------------


@kernel
def take_rows(text, place, stop, begins_with, zulu, separator, second, atto, columns, found):
    """Read rows as far as they are plain: a lead, then numbers, in lines.

    text : bytes, whole lines from `place` to `stop`, and TEXT_MARGIN more
    begins_with : LEAD_NOTHING, LEAD_DATE (with a Z only where `zulu`) or LEAD_WORD, which is passed over
    separator : of values: BLANK for any blanks and tabs, around the row too, and empty lines; or a character
    second, atto : (n,) integers, of dates: LONGEST_DAY times the day, and the second of the day; 1e-18 s
    columns : (c, n); all three are written as far as there are rows
    found : (2,), written: how many rows, and where the first line begins that is not read
    """
    row, blank = 0, separator == BLANK
    last_date, last_mark, last_day = U(0), U(0), np.int64(0)
    while place < stop:
        line = place
        if blank:
            place = _past_blanks(text, place)
        end = _line_end(text, place)
        if blank and end >= 0:
            place = end
            continue
        place, last_date, last_mark, last_day, seconds, part = _take_lead(
            text, place, begins_with, separator, zulu, last_date, last_mark, last_day
        )
        for j in range(columns.shape[0]):
            if place >= 0 and (j > 0 or begins_with != LEAD_NOTHING):
                place = _past_separator(text, place, separator)
            if place < 0:
                break
            value, place = take_number(text, place)
            if place >= 0 and row < columns.shape[1]:
                columns[j, row] = value
        if place >= 0:
            place = _line_end(text, _past_blanks(text, place) if blank else place)
        if place < 0 or row == second.shape[0]:
            place = line
            break
        second[row], atto[row] = seconds, part
        row += 1
    found[0], found[1] = row, place


@kernel
def count_lines(text, first, stop, found):
    """found[0]: how many ends of lines there are from `first` to `stop`."""
    total, place = np.int64(0), first
    while place < stop:
        # Eight bytes at a time, each counting in its own byte as far as that goes; whole vectors of them.
        words = min((stop - place) >> 3, 255)
        counts = U(0)
        for i in range(words):
            other = load(text, place + (i << 3), U(0)) ^ NEWLINES
            low = (other & LOW_BITS) + LOW_BITS
            counts += (~(low | other) & ~LOW_BITS) >> U(7)
        pairs = (counts & U(0x00FF00FF00FF00FF)) + ((counts >> U(8)) & U(0x00FF00FF00FF00FF))
        total += np.int64((pairs * U(0x0001000100010001)) >> U(48))
        place += words << 3
        if words == 0:
            total += np.int64(load(text, place, BYTE(0)) == BYTE(NEWLINE))
            place += 1
    found[0] = total


@inlined
def _take_lead(text, place, begins_with, separator, zulu, last_date, last_mark, last_day):
    """(where it ends, the date seen last as text and day, second, atto); -1 for no plain date."""
    if begins_with == LEAD_DATE:
        date, mark = load(text, place, U(0)), load(text, place + 8, U(0)) & U(0xFFFFFF)
        if date != last_date or mark != last_mark:
            last_date, last_mark, last_day = date, mark, _day(date, mark)
        # 2016-12-31T or 2016-366T
        clock = place + (9 if (mark & U(0xFF)) == U(LARGE_T) else 11)
        if last_day == NO_DAY:
            return np.int64(-1), last_date, last_mark, last_day, last_day, last_day
        place, second, atto = _take_clock(text, clock, zulu)
        return place, last_date, last_mark, last_day, last_day * LONGEST_DAY + second, atto
    if begins_with == LEAD_WORD:
        character = load(text, place, BYTE(0))
        while character != BYTE(separator) and character != BYTE(NEWLINE):
            place += 1
            character = load(text, place, BYTE(0))
    return place, last_date, last_mark, last_day, last_day, last_day


@routine
def _day(date, mark):
    """The modified Julian day of 2016-12- and 31T, or of 2016-366 and T; NO_DAY for anything else."""
    by_month = _digits_of(date, U(0x2D30302D30303030), U(0xFF0000FF00000000))
    if by_month != NO_DIGITS and (mark >> U(16)) == U(LARGE_T):
        day = _digits_of(mark & U(0xFFFF), U(0x3030), U(0xFFFFFFFFFFFF0000))
        if day == NO_DIGITS:
            return np.int64(NO_DAY)
        return _day_of(_year(by_month), _pair(by_month, 40), _pair(day, 0))
    found = _digits_of(date, U(0x3030302D30303030), U(0x000000FF00000000))
    if found == NO_DIGITS or (mark & U(0xFF)) != U(LARGE_T):
        return np.int64(NO_DAY)
    year, day = _year(found), 10 * _pair(found, 40) + np.int64(found >> U(56))
    if day < 1 or day > (366 if _is_leap(year) else 365) or year == 0:
        return np.int64(NO_DAY)
    return _day_of(year, 1, 1) + day - 1


@inlined
def _digits_of(word, form, separators):
    """The digits of a word, a byte each, that is of a form with zeros in their places; or NO_DIGITS."""
    digits = word ^ form
    high = U(0xF0F0F0F0F0F0F0F0)
    wrong = (digits & separators) | (digits & high) | ((digits + U(0x0606060606060606)) & high)
    return NO_DIGITS if wrong != U(0) else digits


@inlined
def _pair(digits, bit):
    pair = digits >> U(bit)
    return np.int64(pair & U(15)) * 10 + np.int64((pair >> U(8)) & U(15))


@inlined
def _year(digits):
    return 100 * _pair(digits, 0) + _pair(digits, 16)


@inlined
def _is_leap(year):
    return year % 4 == 0 and (year % 100 != 0 or year % 400 == 0)


@routine
def _day_of(year, month, day):
    """The modified Julian day of a date of the calendar, from year 1 on; NO_DAY where there is none."""
    if year < 1 or month < 1 or month > 12 or day < 1:
        return np.int64(NO_DAY)
    length = 30 + ((month + month // 8) & 1) if month != 2 else (29 if _is_leap(year) else 28)
    if day > length:
        return np.int64(NO_DAY)
    since_march, years = (month + 9) % 12, year - (1 if month < 3 else 0)
    days = 365 * years + years // 4 - years // 100 + years // 400
    return days + (153 * since_march + 2) // 5 + day - 1 - TO_MARCH


@inlined
def _take_clock(text, place, zulu):
    """(end, second of the day, atto) of 23:59:59.123; end is -1 for none, and second 60."""
    digits = _digits_of(load(text, place, U(0)), U(0x30303A30303A3030), U(0x0000FF0000FF0000))
    if digits == NO_DIGITS:
        return np.int64(-1), np.int64(0), np.int64(0)
    hour, minute, second = _pair(digits, 0), _pair(digits, 24), _pair(digits, 48)
    place, atto = place + 8, np.int64(0)
    if hour > 23 or minute > 59 or second > 59:
        return np.int64(-1), atto, atto
    if load(text, place, BYTE(0)) == BYTE(POINT):
        value, end = take_digits(text, place + 1, U(0))
        count = end - place - 1
        if count < 1 or count > MOST_DECIMALS:
            return np.int64(-1), atto, atto
        place, atto = end, np.int64(value * TEN_TO[MOST_DECIMALS - count])
    if load(text, place, BYTE(0)) == BYTE(LARGE_Z) and zulu != 0:
        place += 1
    return place, 3600 * hour + 60 * minute + second, atto


@inlined
def _past_separator(text, place, separator):
    """-1 where there is none."""
    character = load(text, place, BYTE(0))
    if separator == BLANK:
        if character != BYTE(BLANK) and character != BYTE(TAB):
            return np.int64(-1)
        return _past_blanks(text, place + 1)
    return place + 1 if character == BYTE(separator) else np.int64(-1)


@inlined
def _past_blanks(text, place):
    character = load(text, place, BYTE(0))
    while character == BYTE(BLANK) or character == BYTE(TAB):
        place += 1
        character = load(text, place, BYTE(0))
    return place


@inlined
def _line_end(text, place):
    """Where the next line begins; -1 where this one does not end here."""
    if load(text, place, BYTE(0)) == BYTE(RETURN):
        place += 1
    return place + 1 if load(text, place, BYTE(0)) == BYTE(NEWLINE) else np.int64(-1)
