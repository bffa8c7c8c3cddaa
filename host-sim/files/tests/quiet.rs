//! A caught panic is silent, others are not. Alone in its program, as the panic hook is the whole program's.

use std::panic::{set_hook, take_hook};
use std::sync::atomic::{AtomicU32, Ordering};

use files::quiet::catch;

#[test]
fn a_caught_panic_says_nothing_and_others_are_heard() {
    static HEARD: AtomicU32 = AtomicU32::new(0);
    let before = take_hook();
    set_hook(Box::new(move |panic| {
        HEARD.fetch_add(1, Ordering::SeqCst);
        before(panic);
    }));
    assert_eq!(catch(|| 1), Some(1));
    let numbers = [1];
    let beyond = std::hint::black_box(2);
    assert_eq!(catch(|| numbers[beyond]), None);
    assert_eq!(catch(|| catch(|| numbers[beyond])), Some(None));
    assert_eq!(HEARD.load(Ordering::SeqCst), 0);
    let other = std::thread::spawn(move || numbers[beyond]).join();
    assert!(other.is_err());
    assert_eq!(HEARD.load(Ordering::SeqCst), 1);
}
