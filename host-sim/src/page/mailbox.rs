//! What waits on the way to a page and from it. Both ways are bounded: a page that does not read loses what is oldest, and
//! nobody else waits for it.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde::Serialize;

/// Bytes of streamed messages that wait for a page at most: more than a second of recording.
pub const MAX_WAITING: usize = 256 * 1024;

/// Answers and words that wait for a page at most; with more, its connection ends.
const MAX_ANSWERS: usize = 256;

/// Messages from a page that wait at most.
const MAX_UNREAD: usize = 64;

/// Bytes in one message of the WebSocket.
const BATCH: usize = 32 * 1024;

/// A message from a page or to it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PageMessage {
    /// Bytes for the board, or as a board sends them.
    Wire(Vec<u8>),
    /// Words for the server, or of it, as JSON.
    Words(String),
}

/// What the server says to a page.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Notice<'a> {
    /// The first notice that a page gets.
    Welcome {
        /// The number of the page.
        page: u32,
        /// Name of the board's port.
        board: &'a str,
    },
    /// Who has the seat, that is, commands the board.
    Seat {
        /// The page that commands.
        commander: Option<u32>,
        /// How many pages are connected.
        pages: usize,
        /// Why the seat changed, a line for a person; may be empty.
        why: &'a str,
    },
    /// Whether the board is heard.
    Board {
        /// Whether the board answers.
        up: bool,
        /// Why that changed, a line for a person; may be empty.
        why: &'a str,
    },
    /// Streamed messages that this page has not taken in time and that are lost.
    Lost {
        /// How many messages were lost since the last such notice.
        frames: u64,
    },
}

/// A frame of bytes, or words.
#[derive(Debug)]
enum Item {
    Words(String),
    Answer(Vec<u8>),
    Streamed(Vec<u8>),
}

#[derive(Debug, Default)]
struct Outgoing {
    items: VecDeque<Item>,
    /// Bytes of what is streamed in it.
    waiting: usize,
    /// The other items in it.
    answers: usize,
    /// Streamed messages lost since that was last said.
    lost: u64,
    /// That was the last message: now something else goes first, or a page with many losses would hear of nothing else.
    told: bool,
}

/// A page that is connected.
#[derive(Debug)]
pub struct Mailbox {
    /// The number of the page.
    pub page: u32,
    outgoing: Mutex<Outgoing>,
    incoming: Mutex<VecDeque<PageMessage>>,
    gone: AtomicBool,
    dismissed: AtomicBool,
}

impl Mailbox {
    /// For page number `page`.
    pub fn new(page: u32) -> Self {
        Self {
            page,
            outgoing: Mutex::default(),
            incoming: Mutex::default(),
            gone: AtomicBool::new(false),
            dismissed: AtomicBool::new(false),
        }
    }

    /// Tells the page something.
    pub fn tell(&self, notice: &Notice) {
        // A notice is text and numbers: it always has a form as JSON.
        let words = serde_json::to_string(notice).unwrap_or_default();
        self.put(Item::Words(words));
    }

    /// A frame that answers a request.
    pub fn answer(&self, frame: &[u8]) {
        self.put(Item::Answer(frame.to_vec()));
    }

    /// Puts in what must not be lost.
    fn put(&self, item: Item) {
        let mut outgoing = held(&self.outgoing);
        outgoing.answers += 1;
        outgoing.items.push_back(item);
        if outgoing.answers > MAX_ANSWERS {
            self.dismiss();
        }
    }

    /// A frame of a stream; the oldest ones are lost if there are too many.
    pub fn stream(&self, frame: &[u8]) {
        let mut outgoing = held(&self.outgoing);
        outgoing.waiting += frame.len();
        outgoing.items.push_back(Item::Streamed(frame.to_vec()));
        while outgoing.waiting > MAX_WAITING {
            let oldest = |item: &Item| matches!(item, Item::Streamed(_));
            let Some(at) = outgoing.items.iter().position(oldest) else {
                return;
            };
            if let Some(Item::Streamed(frame)) = outgoing.items.remove(at) {
                outgoing.waiting -= frame.len();
                outgoing.lost += 1;
            }
        }
    }

    /// The next message for the page.
    pub fn take(&self) -> Option<PageMessage> {
        let mut outgoing = held(&self.outgoing);
        outgoing.told = outgoing.lost > 0 && !outgoing.told;
        if outgoing.told {
            let frames = std::mem::take(&mut outgoing.lost);
            let words = serde_json::to_string(&Notice::Lost { frames });
            return Some(PageMessage::Words(words.unwrap_or_default()));
        }
        let mut batch = Vec::new();
        while batch.len() < BATCH {
            match outgoing.items.pop_front() {
                Some(Item::Answer(frame)) => {
                    outgoing.answers -= 1;
                    batch.extend(frame);
                }
                Some(Item::Streamed(frame)) => {
                    outgoing.waiting -= frame.len();
                    batch.extend(frame);
                }
                Some(Item::Words(words)) if batch.is_empty() => {
                    outgoing.answers -= 1;
                    return Some(PageMessage::Words(words));
                }
                Some(words) => {
                    outgoing.items.push_front(words);
                    break;
                }
                None => break,
            }
        }
        (!batch.is_empty()).then_some(PageMessage::Wire(batch))
    }

    /// Takes a message from the page. False: there are too many.
    pub fn receive(&self, message: PageMessage) -> bool {
        let mut incoming = held(&self.incoming);
        let room = incoming.len() < MAX_UNREAD;
        if room {
            incoming.push_back(message);
        }
        room
    }

    /// What has come from the page.
    pub fn received(&self) -> VecDeque<PageMessage> {
        std::mem::take(&mut *held(&self.incoming))
    }

    /// The page's connection has ended.
    pub fn leave(&self) {
        self.gone.store(true, Ordering::Release);
    }

    /// Whether the page's connection has ended.
    pub fn is_gone(&self) -> bool {
        self.gone.load(Ordering::Acquire)
    }

    /// The page's connection is to end.
    pub fn dismiss(&self) {
        self.dismissed.store(true, Ordering::Release);
    }

    /// Whether it is to.
    pub fn is_dismissed(&self) -> bool {
        self.dismissed.load(Ordering::Acquire)
    }
}

/// A panic elsewhere leaves the queues whole: each change to them is one call.
fn held<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_that_does_not_read_loses_the_oldest_and_is_told_how_many() {
        let mailbox = Mailbox::new(1);
        let size = 1024;
        let fits = MAX_WAITING / size;
        mailbox.answer(&[255; 3]);
        for number in 0..fits + 5 {
            mailbox.stream(&vec![number as u8; size]);
        }
        let Some(PageMessage::Words(words)) = mailbox.take() else {
            panic!("what was lost comes first");
        };
        assert_eq!(words, r#"{"kind":"lost","frames":5}"#);
        // What is lost meanwhile waits until something has been sent.
        mailbox.stream(&vec![7; size]);
        let Some(PageMessage::Wire(mut bytes)) = mailbox.take() else {
            panic!("words again");
        };
        let words = mailbox.take();
        assert!(matches!(words, Some(PageMessage::Words(w)) if w.contains("\"frames\":1")));
        while let Some(PageMessage::Wire(batch)) = mailbox.take() {
            assert!(batch.len() < BATCH + size);
            bytes.extend(batch);
        }
        // The answer is still there, and the newest.
        assert_eq!(bytes.len(), 3 + fits * size);
        assert_eq!((bytes[0], bytes[3]), (255, 6));
        assert_eq!(bytes.last(), Some(&7));
    }

    #[test]
    fn a_page_that_asks_and_never_reads_is_dismissed() {
        let mailbox = Mailbox::new(1);
        for _ in 0..MAX_ANSWERS {
            mailbox.answer(&[1]);
        }
        assert!(!mailbox.is_dismissed());
        mailbox.answer(&[1]);
        assert!(mailbox.is_dismissed());
    }

    #[test]
    fn words_and_bytes_keep_their_order() {
        let mailbox = Mailbox::new(1);
        mailbox.stream(&[1]);
        mailbox.answer(&[2]);
        mailbox.tell(&Notice::Board { up: true, why: "" });
        mailbox.stream(&[3]);
        assert_eq!(mailbox.take(), Some(PageMessage::Wire(vec![1, 2])));
        assert!(matches!(mailbox.take(), Some(PageMessage::Words(_))));
        assert_eq!(mailbox.take(), Some(PageMessage::Wire(vec![3])));
        assert_eq!(mailbox.take(), None);
    }

    #[test]
    fn a_page_that_sends_too_much_is_told_so_by_the_result() {
        let mailbox = Mailbox::new(1);
        let message = || PageMessage::Words(String::new());
        assert!((0..MAX_UNREAD).all(|_| mailbox.receive(message())));
        assert!(!mailbox.receive(message()));
        assert_eq!(mailbox.received().len(), MAX_UNREAD);
        assert!(mailbox.receive(message()));
    }
}
