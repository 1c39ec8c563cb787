//! The tour: all stops in order, their captions, and a contact sheet.

use std::collections::HashSet;

use crate::ONE_AT_A_TIME;
use crate::window::Demo;
use crate::x_server::XServer;

#[test]
#[ignore = "long; `visit` looks into it once"]
fn the_tour_shows_eleven_stops_and_leaves_a_contact_sheet() {
    let _one = ONE_AT_A_TIME.lock();
    let Some(server) = XServer::open() else { return };
    let arguments = ["--tour", "--contact-sheet=tour.png", "--size=320x180", "--vpls=64", "--validate"];
    let mut demo = Demo::start(&server, &arguments);
    // The comparison takes as long as it takes, but the window goes on.
    while demo.events().iter().filter(|event| event["event"] == "tour-stop").count() < 11 {
        demo.frames(1);
    }
    demo.wait("the end", |event| event["event"] == "closed");
    let events = demo.events().to_vec();
    let captions: Vec<String> = events
        .iter()
        .filter(|event| event["event"] == "tour-stop")
        .map(|event| event["details"].as_str().unwrap().to_owned())
        .collect();
    assert_eq!(captions.iter().collect::<HashSet<_>>().len(), 11, "{captions:?}");
    let text = std::fs::read_to_string(demo.path("tour.txt")).unwrap();
    assert!(captions.iter().all(|caption| text.contains(caption)), "{text}");
    assert!(!events.iter().any(|event| event["details"]["validation_messages"].as_u64() > Some(0)));

    let sheet = image::open(demo.path("tour.png")).unwrap().to_rgb8();
    if let Some(folder) = std::env::var_os("GLOWWORM_PICTURES") {
        sheet.save(std::path::Path::new(&folder).join("23-tour.png")).unwrap();
    }
    let [width, height] = [sheet.width() / 4, sheet.height() / 3];
    let tiles: Vec<_> = (0..11)
        .map(|stop| {
            let (x, y) = (stop % 4 * width, stop / 4 * height);
            image::imageops::crop_imm(&sheet, x, y, width, height).to_image()
        })
        .collect();
    for (stop, tile) in tiles.iter().enumerate() {
        let colours = tile.pixels().collect::<HashSet<_>>().len();
        assert!(colours > 500, "stop {stop}: {colours} colours");
        assert!(!tiles[..stop].contains(tile), "stop {stop} looks like one before");
    }
}
