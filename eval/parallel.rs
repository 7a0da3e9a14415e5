//! Independent pieces of work on several threads, their results in order.
//!
//! Plain threads and not a work-stealing pool: a piece may wait for what another is making, and must not be handed a third to do
//! meanwhile that waits for itself.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;

/// Does `work` for every number below `count` on `threads` threads, each beginning with the lowest that is left; `done` hears of every
/// result on the calling thread, in the order in which they come. After an error, or when `stop` is set, no further piece is begun.
///
/// Returns the results in order, `None` where nothing was done.
///
/// # Errors
/// That of the lowest piece that failed; that of `done`.
pub fn each<T: Send, E: Send>(
    threads: usize,
    count: usize,
    stop: &AtomicBool,
    work: impl Fn(usize) -> Result<T, E> + Sync,
    mut done: impl FnMut(usize, &T) -> Result<(), E>,
) -> Result<Vec<Option<T>>, E> {
    let (next, failed) = (AtomicUsize::new(0), AtomicBool::new(false));
    let mut results: Vec<Option<T>> = std::iter::repeat_with(|| None).take(count).collect();
    let mut error: Option<(usize, E)> = None;
    std::thread::scope(|scope| {
        let (sender, receiver) = mpsc::channel();
        for _ in 0..threads.clamp(1, count.max(1)) {
            let sender = sender.clone();
            let (next, failed, work) = (&next, &failed, &work);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) && !failed.load(Ordering::Relaxed) {
                    let piece = next.fetch_add(1, Ordering::Relaxed);
                    if piece >= count || sender.send((piece, work(piece))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        for (piece, result) in receiver {
            match result.and_then(|value| done(piece, &value).map(|()| value)) {
                Ok(value) => results[piece] = Some(value),
                Err(problem) => {
                    failed.store(true, Ordering::Relaxed);
                    if error.as_ref().is_none_or(|(first, _)| piece < *first) {
                        error = Some((piece, problem));
                    }
                }
            }
        }
    });
    match error {
        Some((_, error)) => Err(error),
        None => Ok(results),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_order_whatever_the_threads() {
        let stop = AtomicBool::new(false);
        for threads in [1, 2, 7] {
            let mut heard = 0;
            let results = each(
                threads,
                100,
                &stop,
                |i| Ok::<_, ()>(i * i),
                |_, _| {
                    heard += 1;
                    Ok(())
                },
            );
            let expected: Vec<Option<usize>> = (0..100).map(|i| Some(i * i)).collect();
            assert_eq!(results.unwrap(), expected);
            assert_eq!(heard, 100);
        }
        assert_eq!(each(3, 0, &stop, |_| Ok::<u8, ()>(0), |_, _| Ok(())), Ok(vec![]));
    }

    #[test]
    fn an_error_stops_the_rest_and_a_stop_leaves_it_undone() {
        let stop = AtomicBool::new(false);
        let work = |i| if i >= 3 { Err(i) } else { Ok(i) };
        assert_eq!(each(1, 50, &stop, work, |_, _| Ok(())), Err(3));
        let slowly = |i| {
            std::thread::sleep(std::time::Duration::from_millis(5));
            Ok::<_, ()>(i)
        };
        let results = each(1, 50, &stop, slowly, |i, _| {
            stop.fetch_or(i == 4, Ordering::Relaxed);
            Ok(())
        });
        let done = results.unwrap().iter().flatten().count();
        assert!((5..50).contains(&done), "{done}");
    }
}
