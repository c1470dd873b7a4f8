//! Records of a journal on any storage.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};

use crate::Checksum;

/// File operations that a journal needs. Tests implement them with a file that fails at any operation.
pub(super) trait Storage {
    fn length(&mut self) -> io::Result<u64>;
    fn read(&mut self, offset: u64, length: usize) -> io::Result<Vec<u8>>;
    /// Truncates the file to `length` bytes.
    fn cut(&mut self, length: u64) -> io::Result<()>;
    /// Writes bytes at the end.
    fn append(&mut self, bytes: &[u8]) -> io::Result<()>;
    /// Waits until everything is on the disk.
    fn sync(&mut self) -> io::Result<()>;
}

impl Storage for File {
    fn length(&mut self) -> io::Result<u64> {
        Ok(self.metadata()?.len())
    }

    fn read(&mut self, offset: u64, length: usize) -> io::Result<Vec<u8>> {
        self.seek(SeekFrom::Start(offset))?;
        let mut bytes = vec![0; length];
        self.read_exact(&mut bytes)?;
        Ok(bytes)
    }

    fn cut(&mut self, length: u64) -> io::Result<()> {
        self.set_len(length)
    }

    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.write_all(bytes)
    }

    fn sync(&mut self) -> io::Result<()> {
        self.sync_all()
    }
}

/// Reason why a journal cannot be continued.
#[derive(Debug)]
pub(super) enum Unusable {
    Io(io::Error),
    NoJournal,
    Other,
    /// Damaged record, counted from 1.
    Damaged {
        record: usize,
    },
}

impl From<io::Error> for Unusable {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// Length of the line before a record.
const LINE: usize = 16 + 1 + 64 + 1 + 8 + 1;

/// Returns the line before a record: its length, its checksum, and a check of both.
fn line(record: &[u8]) -> String {
    let guarded = format!("{:016x} {}", record.len(), checksum(record));
    let check = checksum(guarded.as_bytes());
    format!("{guarded} {}\n", &check[..8])
}

fn checksum(bytes: &[u8]) -> String {
    let mut sum = Checksum::default();
    sum.bytes(bytes);
    sum.text()
}

/// Returns the length and checksum in a line if its check is correct.
fn parse(line: &[u8]) -> Option<(usize, &str)> {
    let text = std::str::from_utf8(line.strip_suffix(b"\n")?).ok()?;
    let (guarded, check) = text.rsplit_once(' ')?;
    let (length, sum) = guarded.split_once(' ')?;
    let holds = checksum(guarded.as_bytes()).starts_with(check) && check.len() == 8;
    usize::from_str_radix(length, 16).ok().filter(|_| holds).map(|length| (length, sum))
}

/// Content after the records known so far.
enum Next {
    /// Nothing.
    End,
    /// Complete record of this length.
    Whole(usize),
    /// Incomplete record, left by a killed process.
    Torn,
    Damaged,
}

/// Records of a journal.
#[derive(Debug)]
pub(super) struct Records<F> {
    file: F,
    /// Offset and length of every record, including the head.
    places: Vec<(u64, usize)>,
    /// Total length of all whole records in the file.
    whole: u64,
    /// True after a failed append: the last record may be incomplete, so no record may follow it.
    broken: bool,
}

impl<F: Storage> Records<F> {
    /// Reads all records, removes an incomplete one at the end, and writes the head if there is none.
    pub(super) fn open(file: F, head: &[u8]) -> Result<Self, Unusable> {
        let (mut records, torn) = Self::find(file, head)?;
        if torn {
            records.file.cut(records.whole)?;
            records.file.sync()?;
        }
        if records.places.is_empty() {
            records.append(&[head])?;
        }
        Ok(records)
    }

    /// Reads all whole records and changes nothing.
    pub(super) fn look(file: F, head: &[u8]) -> Result<Self, Unusable> {
        Ok(Self::find(file, head)?.0)
    }

    /// Finds all complete records. The flag is true if an incomplete record follows them.
    fn find(file: F, head: &[u8]) -> Result<(Self, bool), Unusable> {
        let mut records = Self { file, places: Vec::new(), whole: 0, broken: false };
        let length = records.file.length()?;
        loop {
            match records.next(length)? {
                Next::End => return Ok((records, false)),
                Next::Whole(size) => records.add(size),
                Next::Torn if records.places.is_empty() && !records.is_begun(length, head)? => {
                    return Err(Unusable::NoJournal);
                }
                Next::Torn => return Ok((records, true)),
                Next::Damaged if records.places.is_empty() => return Err(Unusable::NoJournal),
                Next::Damaged => return Err(Unusable::Damaged { record: records.places.len() + 1 }),
            }
            if records.places.len() == 1 && records.place(0)? != head {
                return Err(Unusable::Other);
            }
        }
    }

    /// Returns true if the file contains the beginning of a journal with this head, or zeros after a power failure.
    fn is_begun(&mut self, length: u64, head: &[u8]) -> io::Result<bool> {
        let found = self.file.read(0, length as usize)?;
        let mut expected = line(head).into_bytes();
        expected.extend(head);
        expected.push(b'\n');
        Ok(expected.starts_with(&found) || found.iter().all(|byte| *byte == 0))
    }

    fn next(&mut self, length: u64) -> io::Result<Next> {
        let left = length - self.whole;
        if left == 0 {
            return Ok(Next::End);
        }
        if left < LINE as u64 {
            return Ok(Next::Torn);
        }
        let line = self.file.read(self.whole, LINE)?;
        let Some((size, sum)) = parse(&line) else {
            // After a power failure a file may end with zeros in place of bytes that were not synced.
            let rest = self.file.read(self.whole, left as usize)?;
            return Ok(if rest.iter().all(|byte| *byte == 0) { Next::Torn } else { Next::Damaged });
        };
        let after = left - LINE as u64;
        if (size as u64).saturating_add(1) > after {
            return Ok(Next::Torn);
        }
        let record = self.file.read(self.whole + LINE as u64, size + 1)?;
        let intact = checksum(&record[..size]) == sum && record[size] == b'\n';
        Ok(match intact {
            true => Next::Whole(size),
            false if size as u64 + 1 == after => Next::Torn,
            false => Next::Damaged,
        })
    }

    fn add(&mut self, size: usize) {
        self.places.push((self.whole + LINE as u64, size));
        self.whole += (LINE + size + 1) as u64;
    }

    fn place(&mut self, index: usize) -> io::Result<Vec<u8>> {
        let missing = || io::Error::new(io::ErrorKind::NotFound, format!("there is no record {index}"));
        let (offset, size) = *self.places.get(index).ok_or_else(missing)?;
        self.file.read(offset, size)
    }

    pub(super) fn file(&self) -> &F {
        &self.file
    }

    /// Returns the number of records after the head.
    pub(super) fn len(&self) -> usize {
        self.places.len().saturating_sub(1)
    }

    pub(super) fn read(&mut self, index: usize) -> io::Result<Vec<u8>> {
        self.place(index + 1)
    }

    pub(super) fn append<R: AsRef<[u8]>>(&mut self, records: &[R]) -> io::Result<()> {
        if self.broken {
            return Err(io::Error::other("an earlier record could not be written"));
        }
        self.broken = true;
        for record in records.iter().map(AsRef::as_ref) {
            self.file.append(line(record).as_bytes())?;
            self.file.append(record)?;
            self.file.append(b"\n")?;
        }
        self.file.sync()?;
        records.iter().for_each(|record| self.add(record.as_ref().len()));
        self.broken = false;
        Ok(())
    }

    pub(super) fn keep_first(&mut self, count: usize) -> io::Result<()> {
        if count >= self.len() {
            return Ok(());
        }
        let (offset, size) = self.places[count];
        self.whole = offset + size as u64 + 1;
        self.places.truncate(count + 1);
        self.file.cut(self.whole)?;
        self.file.sync()
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::rc::Rc;

    use super::*;

    const HEAD: &[u8] = b"version 1\nhurst = [0.8]\n";

    fn framed(record: &[u8]) -> Vec<u8> {
        [line(record).as_bytes(), record, b"\n"].concat()
    }

    fn record(number: u8) -> Vec<u8> {
        // Bytes of all kinds, including line breaks.
        (0..40 + 10 * number).map(|i| i.wrapping_mul(37) ^ number).collect()
    }

    fn journal(records: &[u8]) -> Vec<u8> {
        let mut bytes = framed(HEAD);
        records.iter().for_each(|number| bytes.extend(framed(&record(*number))));
        bytes
    }

    /// Content of a file as the system sees it, and its content after a power failure.
    #[derive(Clone, Debug, Default)]
    struct Disk {
        seen: Vec<u8>,
        synced: Vec<u8>,
    }

    /// File of a process that is killed after `left` operations, in the middle of the next one if it is a write.
    #[derive(Clone, Debug)]
    struct Mortal {
        disk: Rc<RefCell<Disk>>,
        left: usize,
    }

    impl Mortal {
        fn on(content: &[u8], left: usize) -> Self {
            Self { disk: Rc::new(RefCell::new(Disk { seen: content.to_vec(), synced: content.to_vec() })), left }
        }

        fn spend(&mut self) -> io::Result<()> {
            self.left = self.left.checked_sub(1).ok_or_else(|| io::Error::other("killed"))?;
            Ok(())
        }
    }

    impl Storage for Mortal {
        fn length(&mut self) -> io::Result<u64> {
            Ok(self.disk.borrow().seen.len() as u64)
        }

        fn read(&mut self, offset: u64, length: usize) -> io::Result<Vec<u8>> {
            Ok(self.disk.borrow().seen[offset as usize..][..length].to_vec())
        }

        fn cut(&mut self, length: u64) -> io::Result<()> {
            self.spend()?;
            self.disk.borrow_mut().seen.truncate(length as usize);
            Ok(())
        }

        fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
            let alive = self.spend();
            let written = if alive.is_ok() { bytes } else { &bytes[..bytes.len() / 2] };
            self.disk.borrow_mut().seen.extend(written);
            alive
        }

        fn sync(&mut self) -> io::Result<()> {
            self.spend()?;
            let mut disk = self.disk.borrow_mut();
            disk.synced = disk.seen.clone();
            Ok(())
        }
    }

    fn open(content: &[u8]) -> Result<Records<Mortal>, Unusable> {
        Records::open(Mortal::on(content, usize::MAX), HEAD)
    }

    fn contents(records: &mut Records<Mortal>) -> Vec<Vec<u8>> {
        (0..records.len()).map(|index| records.read(index).unwrap()).collect()
    }

    #[test]
    fn a_kill_at_any_operation_loses_no_record() {
        let torn = &framed(&record(5))[..LINE + 20];
        let with = |mut bytes: Vec<u8>, tail: &[u8]| {
            bytes.extend(tail);
            bytes
        };
        for (content, had) in [
            (Vec::new(), vec![]),
            (journal(&[])[..20].to_vec(), vec![]),
            (journal(&[]), vec![]),
            (with(journal(&[]), torn), vec![]),
            (with(journal(&[3, 1]), torn), vec![3, 1]),
            (with(journal(&[3, 1]), &[0; 300]), vec![3, 1]),
        ] {
            let mut left = 0;
            loop {
                let file = Mortal::on(&content, left);
                let disk = Rc::clone(&file.disk);
                let mut kept: Vec<Vec<u8>> = had.iter().map(|number| record(*number)).collect();
                let mut complete = false;
                if let Ok(mut records) = Records::open(file, HEAD) {
                    assert_eq!(contents(&mut records), kept);
                    // Runs are computed in parallel, so a record may follow one that could not be written.
                    let batches = [vec![record(4)], vec![record(0), record(6)], vec![record(2)]];
                    let written = batches.map(|batch| (records.append(&batch).is_ok(), batch));
                    complete = written.iter().all(|(written, _)| *written);
                    kept.extend(written.into_iter().filter(|(written, _)| *written).flat_map(|(_, batch)| batch));
                }
                let Disk { seen, synced } = disk.borrow().clone();
                // A power failure may leave only part of the bytes that were not synced, or zeros in their place.
                let partly = seen[..synced.len().midpoint(seen.len()).min(seen.len())].to_vec();
                let mut zeros = synced.clone();
                zeros.resize(seen.len().max(synced.len()), 0);
                for found in [&seen, &synced, &partly, &zeros] {
                    let mut records = open(found).unwrap_or_else(|error| panic!("{left}: {error:?}"));
                    let found = contents(&mut records);
                    assert!(found.starts_with(&kept), "killed after {left}");
                    // The work continues from this file.
                    records.append(&[record(7)]).unwrap();
                    let whole = records.file.disk.borrow().seen.clone();
                    assert_eq!(open(&whole).unwrap().len(), found.len() + 1);
                }
                if complete {
                    break;
                }
                left += 1;
            }
            assert!(left >= 12, "hardly anything was interrupted: {left}");
        }
    }

    #[test]
    fn a_look_finds_the_whole_records_and_changes_nothing() {
        let torn = [journal(&[1, 2]), framed(&record(3))[..LINE + 5].to_vec()].concat();
        for (content, count) in [(journal(&[1, 2]), 2), (torn, 2), (journal(&[])[..30].to_vec(), 0), (Vec::new(), 0)] {
            let file = Mortal::on(&content, 0);
            let disk = Rc::clone(&file.disk);
            let mut records = Records::look(file, HEAD).unwrap();
            assert_eq!(contents(&mut records), [1, 2].map(record)[..count]);
            assert_eq!(disk.borrow().seen, content);
        }
        assert!(matches!(Records::look(Mortal::on(&journal(&[1]), 0), b"other"), Err(Unusable::Other)));
    }

    #[test]
    fn every_flipped_bit_is_noticed() {
        let good = journal(&[1, 2]);
        let last = good.len() - framed(&record(2)).len();
        let first = framed(HEAD).len();
        for position in 0..good.len() {
            for bit in 0..8 {
                let mut bad = good.clone();
                bad[position] ^= 1 << bit;
                match open(&bad) {
                    Err(Unusable::NoJournal | Unusable::Other) => assert!(position < first, "{position}"),
                    Err(Unusable::Damaged { record }) => {
                        assert_eq!(record, if position < last { 2 } else { 3 }, "{position}");
                    }
                    Err(Unusable::Io(error)) => panic!("{error}"),
                    // The last record cannot be distinguished from one cut by a power failure; it is written again.
                    Ok(mut records) => {
                        assert!(position >= last, "{position}");
                        assert_eq!(contents(&mut records), [record(1)]);
                    }
                }
            }
        }
    }

    #[test]
    fn another_file_is_left_as_it_is() {
        for content in [&b"a letter"[..], b"a letter\n", &[7; 4000], &framed(b"version 2\n")] {
            let file = Mortal::on(content, usize::MAX);
            let disk = Rc::clone(&file.disk);
            assert!(matches!(Records::open(file, HEAD), Err(Unusable::NoJournal | Unusable::Other)));
            assert_eq!(disk.borrow().seen, content);
        }
    }

    #[test]
    fn records_can_be_taken_back() {
        let mut records = open(&journal(&[1, 2, 3])).unwrap();
        records.keep_first(5).unwrap();
        assert_eq!(records.len(), 3);
        records.keep_first(1).unwrap();
        records.append(&[record(4)]).unwrap();
        let whole = records.file.disk.borrow().seen.clone();
        assert_eq!(contents(&mut open(&whole).unwrap()), [record(1), record(4)]);
        assert!(records.read(2).is_err());
    }
}
