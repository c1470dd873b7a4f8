//! Whole numbers between commas that may be numbers with decimal commas: `0,346,-1,303`.

/// Smallest number of columns of a table in which signs and lengths of the numbers tell.
const FEWEST_COLUMNS: usize = 6;

/// Smallest number of signs, and of numbers of one length, that tell.
const FEWEST: usize = 8;

/// Largest ratio of numbers to negative numbers that tells.
const SPARSEST: usize = 8;

/// Counts of the numbers in every second column.
#[derive(Clone, Copy, Debug, Default)]
struct Side {
    count: usize,
    signs: usize,
    leading_zeros: usize,
    negative_zeros: usize,
    exponents: usize,
    /// Smallest and largest number of digits.
    digits: Option<[usize; 2]>,
}

/// Numbers of a table between commas: in the first, third, ... column, and in the others, which may be fractions.
#[derive(Clone, Debug, Default)]
pub(super) struct Pairs {
    sides: [Side; 2],
    /// True if a number is not whole, which excludes decimal commas.
    has_others: bool,
    /// First number with a leading zero in the second, fourth, ... column, and its line.
    example: Option<(usize, String)>,
}

impl Pairs {
    /// Adds the word of a column, from 0.
    pub(super) fn add(&mut self, line: usize, column: usize, word: &str) {
        if word.is_empty() || self.has_others {
            return;
        }
        let unsigned = word.trim_start_matches(['-', '+']);
        let (mantissa, exponent) = unsigned.split_once(['e', 'E']).map_or((unsigned, None), |(m, e)| (m, Some(e)));
        if mantissa.is_empty() || !mantissa.bytes().all(|byte| byte.is_ascii_digit()) {
            self.has_others = true;
            return;
        }
        let is_padded = mantissa.len() > 1 && mantissa.starts_with('0');
        if is_padded && column % 2 == 1 && self.example.is_none() {
            self.example = Some((line, crate::bytes::clip(word)));
        }
        let side = &mut self.sides[column % 2];
        let is_signed = unsigned.len() < word.len();
        side.count += 1;
        side.signs += usize::from(is_signed);
        side.leading_zeros += usize::from(is_padded);
        side.negative_zeros += usize::from(is_signed && mantissa == "0");
        side.exponents += usize::from(exponent.is_some());
        let [least, most] = side.digits.unwrap_or([mantissa.len(); 2]);
        side.digits = Some([least.min(mantissa.len()), most.max(mantissa.len())]);
    }

    /// Returns an error if every second number of a table looks like the fraction of the number before it.
    ///
    /// # Errors
    /// No sign in these columns, and one of: only they have exponents, or leading zeros; the others have the number -0;
    /// in at least six columns, the others have signs, or all of them have as many digits, and none of the others has.
    pub(super) fn check(&self, columns: usize) -> Result<(), String> {
        let [whole, fraction] = &self.sides;
        if self.has_others || columns % 2 == 1 || fraction.signs > 0 || whole.exponents + whole.leading_zeros > 0 {
            return Ok(());
        }
        let of_one_length = || match (whole.digits, fraction.digits) {
            (Some([least, most]), Some([digits, same])) => {
                digits == same && digits > 1 && fraction.count >= FEWEST && !(least..=most).contains(&digits)
            }
            _ => false,
        };
        let has_signs = whole.signs >= FEWEST && SPARSEST * whole.signs >= whole.count;
        let is_doubtful = fraction.exponents > 0
            || fraction.leading_zeros > 0
            || whole.negative_zeros > 0
            || columns >= FEWEST_COLUMNS && (has_signs || of_one_length());
        if !is_doubtful {
            return Ok(());
        }
        let example =
            self.example.as_ref().map_or_else(String::new, |(line, word)| format!(" ({word} in line {line})"));
        Err(format!(
            "the commas may separate numbers or be decimal: every second number looks like a fraction{example}; \
             numbers with decimal commas must have another separator, such as ;, and whole numbers one other than a \
             comma"
        ))
    }
}
