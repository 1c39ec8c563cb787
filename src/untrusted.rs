//! Untrusted input: the content of files, and the decoders of other crates that read it.
//!
//! In: bytes or text of any content. Out: messages without control characters; errors in place of a decoder's panic; decoded
//! text; the format of a file that is not what its extension says.

use std::borrow::Cow;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    static GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread runs within [`guarded`], where a panic is an error and says nothing by itself.
pub(crate) fn is_guarded() -> bool {
    GUARDED.get()
}

/// Runs the decoder of another crate; its panic becomes an error that completes a sentence about the file.
pub(crate) fn guarded<T>(decode: impl FnOnce() -> T) -> Result<T, String> {
    let before = GUARDED.replace(true);
    let result = catch_unwind(AssertUnwindSafe(decode));
    GUARDED.set(before);
    result.map_err(|_| "is malformed (its decoder gave up)".to_owned())
}

/// Characters that move a terminal's cursor, colour it, or turn the direction of text.
fn is_control(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2028}' | '\u{2029}' | '\u{2066}'..='\u{2069}')
}

/// The text with control characters as escapes such as `\u{1b}`, but for the ends of its lines and tabs.
pub(crate) fn printable(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match is_control(c) && !matches!(c, '\n' | '\t') {
            true => shown.extend(c.escape_unicode()),
            false => shown.push(c),
        }
    }
    shown
}

/// The text in one line, with control characters as escapes.
pub(crate) fn one_line(text: &str) -> String {
    printable(&text.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// The name that a misspelt one most likely stands for, if any does.
pub(crate) fn nearest<'a>(text: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let similar = names.into_iter().map(|name| (strsim::jaro(text, name), name));
    similar
        .filter(|(similarity, _)| *similarity > 0.8)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}

/// Text in UTF-8, or in UTF-16 with a byte-order mark; none if it is neither.
pub(crate) fn unicode_of(bytes: &[u8]) -> Option<Cow<'_, str>> {
    let utf16 = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
        let decoded = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
        Some(Cow::Owned(decoded.collect()))
    };
    match bytes {
        [0xff, 0xfe, text @ ..] => utf16(text, u16::from_le_bytes),
        [0xfe, 0xff, text @ ..] => utf16(text, u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, text @ ..] | text => std::str::from_utf8(text).ok().map(Cow::Borrowed),
    }
}

/// Text in UTF-8 or UTF-16, or in Latin-1, as old exporters write it.
pub(crate) fn text_of(bytes: &[u8]) -> Cow<'_, str> {
    unicode_of(bytes).unwrap_or_else(|| bytes.iter().map(|&byte| byte as char).collect::<String>().into())
}

/// Why a file cannot be what its name says, by how it begins; completes a sentence about it.
pub(crate) fn wrong_format(bytes: &[u8]) -> Option<&'static str> {
    let start = String::from_utf8_lossy(&bytes[..bytes.len().min(512)]).to_lowercase();
    let start = start.trim_start_matches('\u{feff}').trim_start();
    Some(match bytes {
        [] => "is empty",
        _ if start.starts_with("version https://git-lfs") => {
            "is a Git LFS pointer, not the file itself; run git lfs pull"
        }
        _ if start.starts_with("<!doctype html") || start.starts_with("<html") => {
            "is HTML, such as the page of a download; download the file itself"
        }
        _ if start.starts_with("<?xml") || start.starts_with("<svg") => "is XML; convert it",
        [b'P', b'K', 3, 4, ..] => "is a ZIP archive; extract it first",
        [0x1f, 0x8b, ..] => "is compressed by gzip; extract it first",
        [b'7', b'z', 0xbc, 0xaf, ..] => "is a 7z archive; extract it first",
        [0xab, b'K', b'T', b'X', b' ', ..] => "is a KTX texture, which is not read; save it as PNG or JPEG",
        _ if bytes.starts_with(b"Kaydara FBX Binary") => "is FBX; convert it to glTF",
        _ if bytes.starts_with(b"BLENDER") => "is a Blender file; export it as glTF",
        _ if bytes.iter().all(|&byte| byte == 0) => "has nothing but zeros; download or export it again",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_controls_the_terminal() {
        for (text, line) in [
            ("a\u{1b}[31mb\u{7}", "a\\u{1b}[31mb\\u{7}"),
            ("a\r\n \tb\u{85}c", "a b c"),
            ("\u{9b}1m \u{202e}x é 日本", "\\u{9b}1m \\u{202e}x é 日本"),
        ] {
            assert_eq!(one_line(text), line);
        }
        assert_eq!(printable("a\tb\n\u{1b}c"), "a\tb\n\\u{1b}c");
    }

    #[test]
    fn misspelt_names_are_known() {
        let names = ["render", "reference", "cornell-box", "cathedral"];
        for (text, name) in [
            ("rendr", Some("render")),
            ("cornel-box", Some("cornell-box")),
            ("cornellbox", Some("cornell-box")),
            ("catedral", Some("cathedral")),
            ("frobnicate", None),
            ("", None),
        ] {
            assert_eq!(nearest(text, names), name, "{text}");
        }
    }

    #[test]
    fn panics_of_decoders_are_errors() {
        assert_eq!(guarded(|| 7), Ok(7));
        let hook = std::panic::take_hook();
        std::panic::set_hook(Box::new(|_| assert!(is_guarded())));
        let failed = guarded(|| Vec::<u8>::new()[std::hint::black_box(3)]);
        std::panic::set_hook(hook);
        assert!(failed.is_err() && !is_guarded());
    }

    #[test]
    fn text_is_decoded_by_its_mark() {
        for (bytes, text) in [
            (&b"v 1"[..], "v 1"),
            (b"\xef\xbb\xbfv\xc3\xa9", "v\u{e9}"),
            (b"\xff\xfev\0\xe9\0", "v\u{e9}"),
            (b"\xfe\xff\0v\0\xe9\x20", "v\u{e9}"),
            (b"v\xe9", "v\u{e9}"),
        ] {
            assert_eq!(text_of(bytes), text);
        }
    }

    #[test]
    fn files_are_told_by_how_they_begin() {
        for (bytes, says) in [
            (&b""[..], "empty"),
            (b"version https://git-lfs.github.com/spec/v1\noid", "Git LFS"),
            (b"\n<!DOCTYPE html><html>", "HTML"),
            (b"PK\x03\x04", "ZIP"),
            (b"\0\0\0\0", "zeros"),
        ] {
            assert!(wrong_format(bytes).is_some_and(|why| why.contains(says)), "{says}");
        }
        assert_eq!(wrong_format(b"v 0 0 0"), None);
    }
}
