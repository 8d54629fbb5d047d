//! `gpu-rt page`: its files, and what it refuses. tests/page renders them in browsers.

use std::fs;

use crate::sandbox::Sandbox;

#[test]
fn a_page_is_a_folder_or_one_file() {
    let sandbox = Sandbox::new();
    let ran = sandbox.says("page ../scenes/sphere.ron -o page --spp 1").exits(0);
    assert_eq!(ran.stdout, "");
    let read = |name: &str| fs::read_to_string(sandbox.at(name)).expect("it is text");
    let html = read("page/index.html");
    for name in ["style.css", "main.js", "picture.png"] {
        assert!(html.contains(name) && sandbox.at(format!("page/{name}")).exists(), "{name}");
    }
    assert!(!html.contains("{{") && html.contains("<title>sphere"), "{html}");
    let plan: serde_json::Value = serde_json::from_str(&read("page/plan.json")).expect("it is JSON");
    assert_eq!(plan["fixed"], false);

    sandbox.says("page ../scenes/sphere.ron -o page.html --single --spp 0 --size 8x6").exits(0);
    let html = read("page.html");
    assert!(!html.contains("import ") && !html.contains("src=") && !html.contains("<img"), "one file, no picture");
    // The JSON ends where its script does.
    let (_, json) = html.split_once("id=\"plan\">").expect("it is there");
    let (json, _) = json.split_once("</script>").expect("it ends");
    let plan: serde_json::Value = serde_json::from_str(json).expect("it is JSON");
    assert_eq!((&plan["size"][0], &plan["fixed"]), (&8.into(), &true.into()));
}

#[test]
fn a_page_refuses_what_it_cannot_show() {
    let sandbox = Sandbox::new();
    for (arguments, words) in [
        ("-o page --aov albedo", "--aov: a page shows the image alone"),
        ("-o page --scatter queues", "--scatter: the kernels of a page are linked"),
        ("-o page --size 4000x4000", "pixels at most; give a smaller --size"),
        ("-o -", "expected the name of a folder"),
        ("--single -o none/page.html", "no page has been written"),
    ] {
        let ran = sandbox.says(&format!("page ../scenes/sphere.ron {arguments}"));
        assert!(ran.code() == 2 && ran.stderr.contains(words), "{arguments}: {}", ran.stderr);
        assert!(!sandbox.at("page").exists(), "{arguments}");
    }
    assert!(sandbox.says("page ../scenes/sphere.ron -o page --clamp 1 --spp 0").exits(0).stderr.contains("--clamp"));
}
