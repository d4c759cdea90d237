//! The engine of the page: `heliotile-core` in a worker of the browser. In: requests as JSON, some
//! with bytes, and the bytes of an archive, which the host reads by ranges ([`host`]). Out: answers
//! as JSON with arrays behind them, or a [`failure`]. The formulas are the core's.
//!
//! The host asks for buffers ([`request_buffer`], [`bytes_buffer`]), writes there, calls
//! [`answer_request`] and reads the text and the arrays at [`text`] and [`arrays`]. The engine owns
//! the buffers, so it follows no pointer of the host. One engine opens one archive.

mod answer;
mod asked;
mod clouds;
mod comfort;
mod engine;
mod failure;
mod fisheye;
mod geometry;
mod host;
mod interactive;
mod light;
mod matching;
mod open;
mod people;
mod receivers;
mod recombined;
mod request;
mod site;
mod textures;
mod weather;

use std::cell::RefCell;

use crate::answer::Answer;
use crate::engine::Engine;
use crate::failure::Failure;

thread_local! {
    static ENGINE: RefCell<Engine> = RefCell::new(Engine::default());
    static REQUEST: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static BYTES: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static TEXT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static ARRAYS: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

/// Returns a buffer for a request of `length` bytes, JSON.
#[unsafe(no_mangle)]
pub extern "C" fn request_buffer(length: usize) -> *mut u8 {
    REQUEST.with_borrow_mut(|bytes| room(bytes, length))
}

/// Returns a buffer for the `length` bytes that go with a request.
#[unsafe(no_mangle)]
pub extern "C" fn bytes_buffer(length: usize) -> *mut u8 {
    BYTES.with_borrow_mut(|bytes| room(bytes, length))
}

fn room(bytes: &mut Vec<u8>, length: usize) -> *mut u8 {
    bytes.clear();
    bytes.resize(length, 0);
    bytes.as_mut_ptr()
}

/// Answers the request in the buffers. Returns 0, or 1 if the request fails. In both cases there is
/// a text.
#[unsafe(no_mangle)]
pub extern "C" fn answer_request() -> u32 {
    let (request, bytes) = (REQUEST.take(), BYTES.take());
    let answer = ENGINE.with_borrow_mut(|engine| engine.answer(&request, bytes));
    let (code, answer) = match answer {
        Ok(answer) => (0, answer),
        Err(failure) => (1, Answer::of(&failure)),
    };
    let (text, arrays) = answer.finish();
    TEXT.set(text);
    ARRAYS.set(arrays);
    code
}

/// Returns the start of the text of the last answer.
#[unsafe(no_mangle)]
pub extern "C" fn text() -> *const u8 {
    TEXT.with_borrow(|text| text.as_ptr())
}

/// Returns the number of bytes of the last answer's text.
#[unsafe(no_mangle)]
pub extern "C" fn text_length() -> usize {
    TEXT.with_borrow(Vec::len)
}

/// Returns the start of the arrays of the last answer.
#[unsafe(no_mangle)]
pub extern "C" fn arrays() -> *const u8 {
    ARRAYS.with_borrow(|arrays| arrays.as_ptr())
}

/// Returns the number of bytes of the last answer's arrays.
#[unsafe(no_mangle)]
pub extern "C" fn arrays_length() -> usize {
    ARRAYS.with_borrow(Vec::len)
}

/// Result of a request.
type Answered = Result<Answer, Failure>;
