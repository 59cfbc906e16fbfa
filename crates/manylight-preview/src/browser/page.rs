//! The page in the browser.

use crate::picture::RenderInfo;
use serde_json::json;

/// Style of the parts that other pages do not have.
pub(super) const LIVE_STYLE: &str = include_str!("live.css");
/// The page itself, by functions of the shared script.
pub(super) const LIVE_SCRIPT: &str = include_str!("live.js");

/// The page, which loads its style and its scripts from beside it.
pub(super) fn html(info: &RenderInfo) -> String {
    let data = json!({
        "title": info.title,
        "version": env!("CARGO_PKG_VERSION"),
        "passes": info.passes,
        "seconds": info.seconds,
        "error": info.error,
    });
    // Escaped, so that no title can end the script element.
    let data = data.to_string().replace('<', "\\u003c");
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>manylight</title>\n<link rel=\"icon\" href=\"data:,\">\n\
         <link rel=\"stylesheet\" href=\"page.css\">\n</head>\n<body>\n\
         <noscript>This page needs JavaScript.</noscript>\n\
         <script type=\"application/json\" id=\"info\">{data}</script>\n\
         <script src=\"shared.js\"></script>\n<script src=\"live.js\"></script>\n</body>\n</html>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_title_ends_the_script() {
        let info = RenderInfo {
            title: "</script><b>".into(),
            ..RenderInfo::default()
        };
        assert!(!html(&info).contains("</script><b>"));
    }

    #[test]
    fn the_page_loads_nothing_from_elsewhere() {
        for part in [&html(&RenderInfo::default()), LIVE_STYLE, LIVE_SCRIPT] {
            assert!(!part.contains("http") && !part.contains("//cdn"));
        }
    }
}
