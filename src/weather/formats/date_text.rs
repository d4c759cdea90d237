//! Dates in the usual notations. In: text, and a column of them. Out: a date and the text after it;
//! the order of day and month in a column.

use heliotile_core::weather::options::DateOrder;
use heliotile_core::weather::time::calendar::Date;

/// Three numbers with separators between them: year, month and day in some order.
struct Numbers {
    values: [u32; 3],
    /// Number of digits of the first number.
    first_digits: usize,
    /// Number of digits of the last number.
    last_digits: usize,
    separator: char,
}

/// Returns the date at the start of a text, and the rest of the text. Where either of two numbers
/// could be the day, `order` decides; without an order there is no date.
pub fn parse_date(text: &str, order: Option<DateOrder>) -> Option<(Date, &str)> {
    if let Some((numbers, rest)) = numbers(text) {
        return Some((numbers.date(order.or_else(|| numbers.only_order()))?, rest));
    }
    if let Some((date, rest)) = text.split_at_checked(8)
        && date.bytes().all(|byte| byte.is_ascii_digit())
    {
        let parts = [date.get(..4)?, date.get(4..6)?, date.get(6..)?].map(|part| part.parse::<u32>().ok());
        return Some((Date::new(i32::try_from(parts[0]?).ok()?, parts[1]?, parts[2]?)?, rest));
    }
    named_month(text)
}

impl Numbers {
    /// Returns the only possible order, if there is one: with a year of four digits in front, or
    /// one of the numbers above 12.
    fn only_order(&self) -> Option<DateOrder> {
        let [first, second, _] = self.values;
        match (first > 12, second > 12) {
            _ if self.first_digits == 4 => Some(DateOrder::Ymd),
            (true, false) => Some(DateOrder::Dmy),
            (false, true) => Some(DateOrder::Mdy),
            _ => None,
        }
    }

    fn date(&self, order: Option<DateOrder>) -> Option<Date> {
        let [a, b, c] = self.values;
        let order = if self.first_digits == 4 { DateOrder::Ymd } else { order? };
        let ((year, digits), month, day) = match order {
            DateOrder::Ymd => ((a, self.first_digits), b, c),
            DateOrder::Dmy => ((c, self.last_digits), b, a),
            DateOrder::Mdy => ((c, self.last_digits), a, b),
        };
        Date::new(full_year(year, digits)?, month, day)
    }
}

/// Returns the full year; two digits stand for 1970 to 2069.
fn full_year(year: u32, digits: usize) -> Option<i32> {
    let year = i32::try_from(year).ok()?;
    match digits {
        4 => Some(year),
        2 if year < 70 => Some(2000 + year),
        2 => Some(1900 + year),
        _ => None,
    }
}

/// Reads `2021-06-01`, `1/6/2021`, `01.06.21` at the start of a text.
fn numbers(text: &str) -> Option<(Numbers, &str)> {
    let (first, rest) = leading_digits(text)?;
    let separator = rest.chars().next().filter(|c| matches!(c, '-' | '/' | '.'))?;
    let (second, rest) = leading_digits(rest.strip_prefix(separator)?)?;
    let (last, rest) = leading_digits(rest.strip_prefix(separator)?)?;
    let right = first.len() <= 4 && second.len() <= 2 && last.len() <= 4 && (first.len() == 4) != (last.len() == 4)
        || [first, second, last].iter().all(|part| part.len() <= 2);
    let value = |text: &str| text.parse::<u32>().ok();
    let values = [value(first)?, value(second)?, value(last)?];
    right.then_some((Numbers { values, first_digits: first.len(), last_digits: last.len(), separator }, rest))
}

fn leading_digits(text: &str) -> Option<(&str, &str)> {
    let end = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    text.split_at_checked(end).filter(|(digits, _)| !digits.is_empty())
}

const MONTHS: [&str; 12] = [
    "january",
    "february",
    "march",
    "april",
    "may",
    "june",
    "july",
    "august",
    "september",
    "october",
    "november",
    "december",
];

/// Reads `1-Jun-2021`, `01 June 2021`, `Jun 1, 2021` at the start of a text.
fn named_month(text: &str) -> Option<(Date, &str)> {
    const BETWEEN: [char; 5] = [' ', '-', ',', '.', '/'];
    let part = |text: &'_ str| -> Option<(usize, usize)> {
        let start = text.len() - text.trim_start_matches(BETWEEN).len();
        let word = text.get(start..)?;
        let length = word.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(word.len());
        (length > 0).then_some((start, start + length))
    };
    let (a, b) = part(text)?;
    let (first, rest) = (text.get(a..b)?, text.get(b..)?);
    let (a, b) = part(rest)?;
    let (second, rest) = (rest.get(a..b)?, rest.get(b..)?);
    let (a, b) = part(rest)?;
    let (year, rest) = (rest.get(a..b)?, rest.get(b..)?);
    let month_of = |word: &str| {
        let lower = word.to_ascii_lowercase();
        let found = MONTHS.iter().position(|name| lower.len() >= 3 && name.starts_with(lower.as_str()));
        found.and_then(|place| u32::try_from(place + 1).ok())
    };
    let (month, day) = match (month_of(first), month_of(second)) {
        (Some(month), None) => (month, second),
        (None, Some(month)) => (month, first),
        _ => return None,
    };
    let number = |text: &str| text.parse::<u32>().ok();
    let year = full_year(number(year)?, year.len())?;
    Some((Date::new(year, month, number(day)?)?, rest))
}

/// Order of day and month that a column of dates shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnOrder {
    /// No date needs an order.
    Plain,
    /// Only this order fits.
    Is(DateOrder),
    /// Either order fits, and nothing decides.
    Unknown,
}

/// Finds the order of a column from its dates, one after the other.
pub struct OrderFinder {
    can: [bool; 2],
    /// Numbers of dates that do not follow the date before, by order.
    jumps: [usize; 2],
    days: [Option<i32>; 2],
    changes: usize,
    dotted: bool,
    seen: bool,
}

const ORDERS: [DateOrder; 2] = [DateOrder::Dmy, DateOrder::Mdy];

impl OrderFinder {
    pub fn new() -> Self {
        OrderFinder { can: [true; 2], jumps: [0; 2], days: [None; 2], changes: 0, dotted: true, seen: false }
    }

    /// Adds the next cell of the column.
    pub fn add(&mut self, text: &str) {
        let Some((numbers, _)) = numbers(text.trim()) else { return };
        if numbers.first_digits == 4 {
            return;
        }
        self.seen = true;
        self.dotted &= numbers.separator == '.';
        let mut changed = false;
        // In the right order days follow each other; in the wrong one they jump.
        for (place, order) in ORDERS.into_iter().enumerate() {
            let Some(date) = numbers.date(Some(order)) else {
                self.can[place] = false;
                continue;
            };
            let day = date.day_number();
            if let Some(before) = self.days[place]
                && before != day
            {
                changed = true;
                self.jumps[place] += usize::from(day != before + 1);
            }
            self.days[place] = Some(day);
        }
        self.changes += usize::from(changed);
    }

    /// Returns the order. A number above 12 decides first, then the dot, which stands between day
    /// and month in this order only, then dates that follow each other in one order only.
    pub fn order(&self) -> ColumnOrder {
        match self.can {
            _ if !self.seen => ColumnOrder::Plain,
            [false, true] => ColumnOrder::Is(DateOrder::Mdy),
            // If neither order fits a column, the row that does not fit is refused later.
            [_, false] => ColumnOrder::Is(DateOrder::Dmy),
            _ if self.dotted => ColumnOrder::Is(DateOrder::Dmy),
            _ if self.changes == 0 => ColumnOrder::Unknown,
            _ => match self.jumps.map(|jumps| jumps == 0) {
                [true, false] => ColumnOrder::Is(DateOrder::Dmy),
                [false, true] => ColumnOrder::Is(DateOrder::Mdy),
                _ => ColumnOrder::Unknown,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A day above 12, dots and days that follow each other decide six of eight columns of dates.
    /// One date alone is unknown, and ISO dates need no order.
    #[test]
    fn a_column_of_dates_decides_their_order() {
        let order = |cells: &[&str]| {
            let mut finder = OrderFinder::new();
            cells.iter().for_each(|cell| finder.add(cell));
            finder.order()
        };
        let (dmy, mdy) = (ColumnOrder::Is(DateOrder::Dmy), ColumnOrder::Is(DateOrder::Mdy));
        for (cells, expected) in [
            (&["01/06/2021 00:00", "13/06/2021 00:00"][..], dmy),
            (&["06/01/2021 00:00", "06/13/2021 00:00"], mdy),
            (&["01.06.2021", "01.06.2021"], dmy),
            (&["01/06/2021", "01/06/2021", "02/06/2021"], dmy),
            (&["06/01/2021", "06/01/2021", "06/02/2021"], mdy),
            (&["31/12/2020", "01/01/2021"], dmy),
            (&["01/06/2021", "01/06/2021"], ColumnOrder::Unknown),
            (&["2021-06-01", "2021-06-02"], ColumnOrder::Plain),
        ] {
            assert_eq!(order(cells), expected, "{cells:?}");
        }
    }
}
