//! Spans on consecutive rows, stored compactly.

/// A half-open interval `start..end` along a row, `start < end` \[units of the row frame\].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Span {
    /// First position inside.
    pub start: i32,
    /// First position behind.
    pub end: i32,
}

impl Span {
    /// Length \[units\].
    pub fn length(self) -> i64 {
        i64::from(self.end) - i64::from(self.start)
    }
}

/// An area as spans on consecutive rows of a frame (compressed sparse rows).
///
/// The spans of a row ascend and neither overlap nor touch; that makes the form canonical up to
/// empty rows at either end.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rows {
    first: i32,
    /// Per row where its spans begin; the last entry is the total. Empty when there are no rows.
    offset: Vec<u32>,
    spans: Vec<Span>,
}

impl Rows {
    /// Rows from `first` on: the spans of the i-th lie at `offset[i]..offset[i + 1]` of `spans`, all counted
    /// from `offset[0]`; spans ascend within a row and neither overlap nor touch. Empty rows at either end
    /// are left out. `None` when the offsets descend or do not cover the spans.
    pub(super) fn from_parts(first: i32, offset: &[u32], spans: Vec<Span>) -> Option<Self> {
        let ascend = offset.windows(2).all(|pair| pair[0] <= pair[1]);
        let (begin, end) = (*offset.first()?, *offset.last()?);
        if !ascend || (end - begin) as usize != spans.len() {
            return None;
        }
        if spans.is_empty() {
            return Some(Self::default());
        }
        let above = offset.partition_point(|&o| o == begin) - 1;
        let below = offset.partition_point(|&o| o < end);
        let offset = offset[above..=below].iter().map(|o| o - begin).collect();
        Some(Self { first: first + above as i32, offset, spans })
    }

    /// Index of the first stored row.
    #[inline]
    pub fn first(&self) -> i32 {
        self.first
    }

    /// Index behind the last stored row.
    #[inline]
    pub fn end(&self) -> i32 {
        self.first + self.offset.len().saturating_sub(1) as i32
    }

    /// The spans of row `k`; empty for rows not stored.
    #[inline]
    pub fn row(&self, k: i32) -> &[Span] {
        &self.spans[self.range(k)]
    }

    /// Where the spans of row `k` lie in [`Self::spans`]; empty for rows not stored.
    #[inline]
    pub fn range(&self, k: i32) -> std::ops::Range<usize> {
        if k < self.first || k >= self.end() {
            return 0..0;
        }
        let i = (k - self.first) as usize;
        self.offset[i] as usize..self.offset[i + 1] as usize
    }

    /// All spans, row by row.
    pub fn spans(&self) -> &[Span] {
        &self.spans
    }

    /// True without any span.
    pub fn is_empty(&self) -> bool {
        self.spans.is_empty()
    }

    /// The stored rows in ascending order, empty ones included.
    pub fn iter(&self) -> impl Iterator<Item = (i32, &[Span])> {
        (self.first..self.end()).map(|k| (k, self.row(k)))
    }

    /// Sum of all span lengths \[units\]; times the pitch \[units\] it is the area \[units²\].
    pub fn length(&self) -> i64 {
        self.spans.iter().map(|s| s.length()).sum()
    }
}

/// Builds [`Rows`] row by row.
#[derive(Debug, Default)]
pub struct RowsBuilder {
    rows: Rows,
    begun: usize,
}

impl RowsBuilder {
    /// Starts at row `first`.
    pub fn new(first: i32) -> Self {
        Self { rows: Rows { first, offset: vec![0], spans: Vec::new() }, begun: 0 }
    }

    /// Starts at row `first` with room for that many spans and rows.
    pub fn with_capacity(first: i32, rows: usize, spans: usize) -> Self {
        let mut offset = Vec::with_capacity(rows + 1);
        offset.push(0);
        Self { rows: Rows { first, offset, spans: Vec::with_capacity(spans) }, begun: 0 }
    }

    /// Appends a span to the current row. Starts must not descend within a row; an empty span is
    /// dropped, one that overlaps or touches the one before is merged into it.
    #[inline]
    pub fn push(&mut self, start: i32, end: i32) {
        if start >= end {
            return;
        }
        if self.rows.spans.len() > self.begun
            && let Some(last) = self.rows.spans.last_mut()
            && start <= last.end
        {
            last.end = last.end.max(end);
            return;
        }
        self.rows.spans.push(Span { start, end });
    }

    /// Ends the current row and begins the next.
    #[inline]
    pub fn end_row(&mut self) {
        self.begun = self.rows.spans.len();
        self.rows.offset.push(self.begun as u32);
    }

    /// The rows ended so far.
    pub fn finish(mut self) -> Rows {
        self.rows.spans.truncate(self.begun);
        self.rows
    }
}
