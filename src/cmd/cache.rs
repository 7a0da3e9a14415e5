//! The cache of tracks that a command was given.

use crate::args::CacheArgs;
use crate::ui::errln;
use anyhow::Result;
use dpn_eval::closed_loop::TrackCache;

/// The cache, where one was named.
pub(crate) fn open(args: &CacheArgs) -> Result<Option<TrackCache>> {
    let open = |dir| TrackCache::open(dir, args.cache_size);
    Ok(args.cache.as_ref().map(open).transpose()?)
}

/// Says what was taken from it and made, and what was wrong.
pub(crate) fn say(cache: Option<&TrackCache>) {
    for line in cache.map(TrackCache::words).unwrap_or_default() {
        errln!("{line}");
    }
}
