//! Serialisation of values to 64-bit words.

/// Value that can be sent between processes as 64-bit words, such as the result of a sum.
pub trait Serialise: Send + Sized {
    /// Number of words.
    const WORDS: usize;

    /// Writes the words.
    fn put(&self, words: &mut [u64]);

    /// Reads a value from its words.
    fn get(words: &[u64]) -> Self;
}

impl Serialise for () {
    const WORDS: usize = 0;

    fn put(&self, _: &mut [u64]) {}

    fn get(_: &[u64]) -> Self {}
}

impl Serialise for f64 {
    const WORDS: usize = 1;

    fn put(&self, words: &mut [u64]) {
        words[0] = self.to_bits();
    }

    fn get(words: &[u64]) -> Self {
        Self::from_bits(words[0])
    }
}

impl Serialise for f32 {
    const WORDS: usize = 1;

    fn put(&self, words: &mut [u64]) {
        words[0] = self.to_bits().into();
    }

    fn get(words: &[u64]) -> Self {
        Self::from_bits(words[0] as u32)
    }
}

impl Serialise for u64 {
    const WORDS: usize = 1;

    fn put(&self, words: &mut [u64]) {
        words[0] = *self;
    }

    fn get(words: &[u64]) -> Self {
        words[0]
    }
}

impl Serialise for usize {
    const WORDS: usize = 1;

    fn put(&self, words: &mut [u64]) {
        words[0] = *self as u64;
    }

    fn get(words: &[u64]) -> Self {
        words[0] as Self
    }
}

impl Serialise for bool {
    const WORDS: usize = 1;

    fn put(&self, words: &mut [u64]) {
        words[0] = u64::from(*self);
    }

    fn get(words: &[u64]) -> Self {
        words[0] != 0
    }
}

impl<P: Serialise, const K: usize> Serialise for [P; K] {
    const WORDS: usize = K * P::WORDS;

    fn put(&self, words: &mut [u64]) {
        self.iter().enumerate().for_each(|(k, part)| part.put(&mut words[k * P::WORDS..][..P::WORDS]));
    }

    fn get(words: &[u64]) -> Self {
        std::array::from_fn(|k| P::get(&words[k * P::WORDS..][..P::WORDS]))
    }
}

macro_rules! tuples {
    ($($part:ident $place:tt),*) => {
        impl<$($part: Serialise),*> Serialise for ($($part,)*) {
            const WORDS: usize = 0 $(+ $part::WORDS)*;

            fn put(&self, words: &mut [u64]) {
                let mut at = 0;
                $(
                    self.$place.put(&mut words[at..at + $part::WORDS]);
                    at += $part::WORDS;
                )*
                debug_assert_eq!(at, Self::WORDS);
            }

            fn get(words: &[u64]) -> Self {
                let mut parts = Words(words);
                ($(parts.next::<$part>(),)*)
            }
        }
    };
}

/// Words to read values from, one after another.
struct Words<'a>(&'a [u64]);

impl Words<'_> {
    fn next<P: Serialise>(&mut self) -> P {
        let (own, rest) = self.0.split_at(P::WORDS);
        self.0 = rest;
        P::get(own)
    }
}

tuples!(A 0, B 1);
tuples!(A 0, B 1, C 2);
tuples!(A 0, B 1, C 2, D 3);
tuples!(A 0, B 1, C 2, D 3, E 4);

/// Number that fills a 64-bit word or half of one.
pub trait Word: Copy + Default + Send + Sync {
    /// Numbers per word.
    const EACH: usize;

    /// Packs at most [`EACH`](Self::EACH) numbers into a word.
    fn packed(numbers: &[Self]) -> u64;

    /// Unpacks the numbers of a word.
    fn unpacked(word: u64, numbers: &mut [Self]);

    /// Returns the number of words that hold `numbers` numbers.
    fn words(numbers: usize) -> usize {
        numbers.div_ceil(Self::EACH)
    }

    /// Packs `numbers` into `words`.
    fn pack(numbers: &[Self], words: &mut [u64]) {
        for (word, numbers) in words.iter_mut().zip(numbers.chunks(Self::EACH)) {
            *word = Self::packed(numbers);
        }
    }

    /// Unpacks several parts and joins them; each part begins with a new word.
    fn joined(words: Vec<u64>, lengths: impl Iterator<Item = usize>) -> Vec<Self> {
        let mut all = Vec::new();
        let mut rest = &words[..];
        for length in lengths {
            let (part, after) = rest.split_at(Self::words(length));
            all.resize(all.len() + length, Self::default());
            let start = all.len() - length;
            Self::unpack(part, &mut all[start..]);
            rest = after;
        }
        all
    }

    /// Unpacks `words` into `numbers`.
    fn unpack(words: &[u64], numbers: &mut [Self]) {
        for (word, numbers) in words.iter().zip(numbers.chunks_mut(Self::EACH)) {
            Self::unpacked(*word, numbers);
        }
    }
}

impl Word for f64 {
    const EACH: usize = 1;

    fn packed(numbers: &[Self]) -> u64 {
        numbers[0].to_bits()
    }

    fn unpacked(word: u64, numbers: &mut [Self]) {
        numbers[0] = Self::from_bits(word);
    }

    /// Reuses the memory of the words.
    fn joined(words: Vec<u64>, _: impl Iterator<Item = usize>) -> Vec<Self> {
        words.into_iter().map(Self::from_bits).collect()
    }
}

impl Word for f32 {
    const EACH: usize = 2;

    fn packed(numbers: &[Self]) -> u64 {
        numbers.iter().rev().fold(0, |word, number| word << 32 | u64::from(number.to_bits()))
    }

    fn unpacked(mut word: u64, numbers: &mut [Self]) {
        for number in numbers {
            *number = Self::from_bits(word as u32);
            word >>= 32;
        }
    }
}

impl Word for u64 {
    const EACH: usize = 1;

    fn packed(numbers: &[Self]) -> u64 {
        numbers[0]
    }

    fn unpacked(word: u64, numbers: &mut [Self]) {
        numbers[0] = word;
    }
}
