//! Pictures in parts, interrupted, and on full disks: the same bits, or a clear error.

use std::io::Read;
use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use mieux::io::image::{ExrImage, read_exr};

const MIEUX: &str = env!("CARGO_BIN_EXE_mieux");

fn command(folder: &Path, words: &[&str]) -> Command {
    let mut command = Command::new(MIEUX);
    command.args(words).current_dir(folder);
    command
}

fn mieux(folder: &Path, words: &[&str]) -> Output {
    command(folder, words).output().unwrap()
}

fn done(folder: &Path, words: &[&str]) -> String {
    let output = mieux(folder, words);
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The code and the text of an error, without the line breaks of its frame.
fn failed(output: &Output) -> (Option<i32>, String) {
    let text = String::from_utf8_lossy(&output.stderr).replace(['│', '╰', '╭', '─', '×', '·'], " ");
    (output.status.code(), text.split_whitespace().collect::<Vec<_>>().join(" "))
}

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).unwrap()
}

fn exr(folder: &Path, name: &str) -> ExrImage {
    read_exr(&folder.join(name).join("picture.exr")).unwrap()
}

/// The answer of a child, which is killed after a minute.
fn bounded(mut child: Child) -> bool {
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(60) {
        if let Some(status) = child.try_wait().unwrap() {
            return status.success();
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    false
}

const MILK: [&str; 6] = ["render", "whole-milk", "--size", "40x36", "--seed", "3"];

#[test]
fn killed_at_any_moment_it_goes_on_to_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let words = [&MILK[..], &["--spp", "12", "--checkpoint", "1ms", "-o"]].concat();
    let run = |out: &'static str, more: &[&'static str]| [&words[..], &[out], more].concat();
    done(folder.path(), &run("whole", &[]));
    let checkpoint = folder.path().join("killed/render.checkpoint");
    let (mut state, mut interrupted) = (12_345_u64, 0);
    for trial in 0..20 {
        let mut child = command(folder.path(), &run("killed", &[])).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
        let child = child.as_mut().unwrap();
        let start = Instant::now();
        while !checkpoint.exists() && child.try_wait().unwrap().is_none() && start.elapsed().as_secs() < 60 {
            std::thread::sleep(Duration::from_millis(1));
        }
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        std::thread::sleep(Duration::from_micros((state >> 33) % 200_000));
        // SIGKILL; a child that has ended already is no matter.
        let _ = child.kill();
        child.wait().unwrap();
        let more: &[&str] = if checkpoint.exists() { &["--resume"] } else { &[] };
        interrupted += more.len();
        done(folder.path(), &run("killed", more));
        for file in ["picture.exr", "picture.png"] {
            let (a, b) =
                (bytes(folder.path(), &format!("killed/{file}")), bytes(folder.path(), &format!("whole/{file}")));
            assert!(a == b, "{file} differs in trial {trial}");
        }
        assert!(!checkpoint.exists());
        std::fs::remove_dir_all(folder.path().join("killed")).unwrap();
    }
    assert!(interrupted > 0, "no trial was interrupted");
}

#[test]
fn parts_make_the_same_bits_as_the_whole_or_a_clear_error() {
    let folder = tempfile::tempdir().unwrap();
    let words =
        [&MILK[..], &["--spp", "8", "--filter", "gaussian", "--spectral=4", "--crop", "3,2,36,30", "-o"]].concat();
    done(folder.path(), &[&words[..], &["whole"]].concat());
    for part in ["1/3", "2/3", "3/3"] {
        let out = part.replace('/', "of");
        done(folder.path(), &[&words[..], &[&out, "--shard", part]].concat());
    }
    done(folder.path(), &["merge", "2of3", "3of3", "1of3", "-o", "merged"]);
    for file in ["picture.exr", "picture.png"] {
        let read = |name: &str| bytes(folder.path(), &format!("{name}/{file}"));
        assert!(read("merged") == read("whole"), "{file}");
    }
    let other = ["render", "whole-milk", "--size", "40x36", "--seed", "4"];
    done(folder.path(), &[&other[..], &words[6..], &["other", "--shard", "2/3"]].concat());
    for (parts, text) in [
        (&["1of3", "2of3"][..], "missing: 3"),
        (&["1of3", "2of3", "2of3", "3of3"], "part 2/3 is there twice"),
        (&["1of3", "other", "3of3"], "different pictures"),
        (&["1of3", "nowhere"], "nowhere"),
    ] {
        let (code, error) = failed(&mieux(folder.path(), &[&["merge", "-o", "no"], parts].concat()));
        assert!(code == Some(2) && error.contains(text), "{parts:?}: {error}");
    }
    let (code, error) = failed(&mieux(folder.path(), &[&MILK[..], &["--noise", "5%", "--shard", "1/2"]].concat()));
    assert!(code == Some(2) && error.contains("--spp"), "{error}");
}

#[test]
fn a_window_holds_the_bits_of_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    done(folder.path(), &[&MILK[..], &["--spp", "8", "--filter", "mitchell", "--spectral", "-o", "whole"]].concat());
    let crop = ["--spp", "8", "--filter", "mitchell", "--spectral", "--crop", "5,9,21,17", "-o", "crop"];
    done(folder.path(), &[&MILK[..], &crop].concat());
    let (whole, crop) = (exr(folder.path(), "whole"), exr(folder.path(), "crop"));
    assert_eq!((crop.size.width(), crop.size.height()), (21, 17));
    // 3 colours, 3 variances, samples, 3 + 3 + 1 features, 16 bins.
    assert_eq!((crop.channels.len(), whole.channels.len()), (30, 30));
    for (name, values) in &crop.channels {
        for (i, value) in values.iter().enumerate() {
            let of_whole = whole.channels[name][(9 + i / 21) * 40 + 5 + i % 21];
            assert_eq!(value.to_bits(), of_whole.to_bits(), "{name} {i}");
        }
    }
    let outside = [&MILK[..], &["--crop", "30,0,11,5"]].concat();
    let (code, error) = failed(&mieux(folder.path(), &outside));
    assert!(code == Some(2) && error.contains("beyond a picture"), "{error}");
    assert!(!folder.path().join("out").exists());
}

#[test]
fn a_full_disk_leaves_the_last_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    let words = [&MILK[..], &["--checkpoint", "1ms", "-o", "a", "--spp"]].concat();
    let mut child = command(folder.path(), &[&words[..], &["100000"]].concat()).stdout(Stdio::null()).spawn().unwrap();
    let checkpoint = folder.path().join("a/render.checkpoint");
    let start = Instant::now();
    while !checkpoint.exists() && start.elapsed().as_secs() < 60 {
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let last = std::fs::read(&checkpoint).unwrap();
    // No file may grow beyond 16 blocks; the signal that comes with it is ignored, so that writing fails as on a full disk.
    let resume = [&[MIEUX], &words[..], &["24", "--resume"]].concat().join(" ");
    let script = format!("trap '' XFSZ; ulimit -f 16; exec {resume}");
    let (code, error) =
        failed(&Command::new("bash").args(["-c", &script]).current_dir(folder.path()).output().unwrap());
    assert!(code == Some(1) && error.contains("cannot be written"), "{code:?} {error}");
    assert!(std::fs::read(&checkpoint).unwrap() == last);
    // And from there it goes on.
    done(folder.path(), &[&words[..], &["24", "--resume"]].concat());
    done(folder.path(), &[&MILK[..], &["--spp", "24", "-o", "b"]].concat());
    assert!(bytes(folder.path(), "a/picture.exr") == bytes(folder.path(), "b/picture.exr"));
    for (bad, text) in [(last[..last.len() / 2].to_vec(), "not a whole checkpoint"), (changed(&last), "checksum")] {
        std::fs::write(&checkpoint, &bad).unwrap();
        let (code, error) = failed(&mieux(folder.path(), &[&words[..], &["24", "--resume"]].concat()));
        assert!(code == Some(2) && error.contains(text), "{error}");
        assert!(std::fs::read(&checkpoint).unwrap() == bad);
    }
    std::fs::write(&checkpoint, &last).unwrap();
    let other = ["render", "skim-milk", "--size", "40x36", "--seed", "3", "--resume", "--spp", "24", "-o", "a"];
    let (code, error) = failed(&mieux(folder.path(), &other));
    assert!(code == Some(2) && error.contains("belongs to another render"), "{error}");
    assert!(std::fs::read(&checkpoint).unwrap() == last);
}

fn changed(file: &[u8]) -> Vec<u8> {
    let mut file = file.to_vec();
    let middle = file.len() - 40;
    file[middle] ^= 1;
    file
}

#[test]
fn every_tile_reaches_the_noise_asked_for_after_an_interruption_too() {
    let folder = tempfile::tempdir().unwrap();
    let words = [&MILK[..], &["--noise", "12%", "--checkpoint", "1ms", "-o"]].concat();
    let report = done(folder.path(), &[&words[..], &["a"]].concat());
    let worst = report.split("relative error per pixel").nth(1).unwrap().split(", ").nth(1).unwrap();
    let percent: f64 = worst.split(' ').next().unwrap().parse().unwrap();
    assert!(percent <= 12.0, "{report}");
    let samples = &exr(folder.path(), "a").channels["samples"];
    let (least, most) = samples.iter().fold((f32::MAX, 0f32), |(l, m), s| (l.min(*s), m.max(*s)));
    assert!(least >= 16.0 && most > least, "{least} {most}");
    let mut child = command(folder.path(), &[&words[..], &["b"]].concat()).stdout(Stdio::null()).spawn().unwrap();
    let checkpoint = folder.path().join("b/render.checkpoint");
    let start = Instant::now();
    while !checkpoint.exists() && child.try_wait().unwrap().is_none() && start.elapsed().as_secs() < 60 {
        std::thread::sleep(Duration::from_millis(1));
    }
    std::thread::sleep(Duration::from_millis(100));
    let _ = child.kill();
    child.wait().unwrap();
    let more: &[&str] = if checkpoint.exists() { &["b", "--resume"] } else { &["b"] };
    done(folder.path(), &[&words[..], more].concat());
    assert!(bytes(folder.path(), "a/picture.exr") == bytes(folder.path(), "b/picture.exr"));
}

#[test]
fn a_viewer_is_shown_the_picture_and_its_absence_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let preview = format!("--preview={}", listener.local_addr().unwrap());
    let child = command(folder.path(), &[&MILK[..], &["--spp", "2", "-o", "a", &preview]].concat())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let server = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        let mut all = Vec::new();
        stream.read_to_end(&mut all).unwrap();
        all
    });
    assert!(bounded(child));
    let all = server.join().unwrap();
    assert_eq!(all[4], 4, "an image is created first");
    let first = u32::from_le_bytes(all[..4].try_into().unwrap()) as usize;
    assert_eq!(all[first + 4], 6, "and then updated");
    let report = done(folder.path(), &[&MILK[..], &["--spp", "2", "-o", "b", "--preview=127.0.0.1:1"]].concat());
    assert!(report.contains("127.0.0.1:1"), "{report}");
}

#[test]
fn tones_change_the_png_alone() {
    let folder = tempfile::tempdir().unwrap();
    let short = [&MILK[..], &["--spp", "1", "-o"]].concat();
    done(folder.path(), &[&short[..], &["plain"]].concat());
    done(folder.path(), &[&short[..], &["srgb", "--tone", "srgb", "--exposure", "0"]].concat());
    done(folder.path(), &[&short[..], &["film", "--tone", "filmic", "--exposure", "-0.5"]].concat());
    let read = |name: &str| bytes(folder.path(), name);
    assert!(read("plain/picture.png") == read("srgb/picture.png"));
    assert!(read("plain/picture.png") != read("film/picture.png"));
    assert!(read("plain/picture.exr") == read("film/picture.exr"));
}
