//! Sends pictures to the viewer `tev` while they grow, by the TCP protocol it documents.
//!
//! A message is its length in bytes (`u32`, itself included), a byte for its kind, a byte for whether the viewer comes to
//! the front, and the fields of the kind. Numbers are little endian, text ends in a zero byte.
//!
//! | kind | fields after the name of the picture |
//! |---|---|
//! | 4, create | width, height, channels (`i32`), the channels' names |
//! | 6, update | channels (`i32`), their names, left, top, width, height (`i32`), per channel where it starts in the data, then per channel how far apart its values are (`i64`, in values), the data (`f32`) |

use std::io::{self, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

/// Where `tev` listens unless told otherwise.
pub const DEFAULT_ADDRESS: &str = "127.0.0.1:14158";

/// Longest wait for the viewer to answer or to take data.
const PATIENCE: Duration = Duration::from_secs(2);
/// Side of the squares in which changes are sent, pixels.
const SIDE: u32 = 64;

/// Why a viewer shows nothing.
#[derive(Debug, thiserror::Error)]
pub enum TevError {
    /// Nobody listens there, or it is no address.
    #[error("no viewer can be reached at {address}: {source}")]
    Connect {
        /// The address.
        address: String,
        /// Why.
        source: io::Error,
    },
    /// It listened once.
    #[error("the viewer takes nothing more: {0}")]
    Send(#[from] io::Error),
}

/// A picture in a viewer.
#[derive(Debug)]
pub struct Viewer {
    stream: TcpStream,
    name: String,
    size: [u32; 2],
    shown: Option<Vec<[f32; 3]>>,
}

impl Viewer {
    /// Opens a black picture of `[width, height]` pixels at an address as in [`DEFAULT_ADDRESS`].
    ///
    /// # Errors
    /// [`TevError`], within a few seconds.
    pub fn open(address: &str, name: &str, size: [u32; 2]) -> Result<Self, TevError> {
        let unreachable = |source| TevError::Connect { address: address.into(), source };
        let mut last = io::Error::new(io::ErrorKind::NotFound, "the name stands for no address");
        for place in address.to_socket_addrs().map_err(unreachable)?.take(4) {
            match TcpStream::connect_timeout(&place, PATIENCE) {
                Ok(stream) => {
                    stream.set_write_timeout(Some(PATIENCE))?;
                    let name = name.replace('\0', "");
                    let mut viewer = Self { stream, name, size, shown: None };
                    viewer.create()?;
                    return Ok(viewer);
                }
                Err(error) => last = error,
            }
        }
        Err(unreachable(last))
    }

    fn create(&mut self) -> io::Result<()> {
        let mut body = self.head(4, true);
        for number in [self.size[0], self.size[1], 3] {
            body.extend(number.to_le_bytes());
        }
        CHANNELS.iter().for_each(|name| put_text(&mut body, name));
        self.send(body)
    }

    /// Shows the picture (row by row from the top) as far as it has changed.
    ///
    /// # Errors
    /// [`TevError::Send`]; the viewer is of no more use then.
    pub fn update(&mut self, picture: &[[f32; 3]]) -> Result<(), TevError> {
        let [width, height] = self.size;
        if picture.len() != width as usize * height as usize {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "the picture has another size").into());
        }
        let shown = self.shown.take();
        for top in (0..height).step_by(SIDE as usize) {
            for left in (0..width).step_by(SIDE as usize) {
                let (w, h) = (SIDE.min(width - left), SIDE.min(height - top));
                let row = |y: u32| {
                    let start = (top + y) as usize * width as usize + left as usize;
                    start..start + w as usize
                };
                let bits = |p: &[f32; 3]| p.map(f32::to_bits);
                let same = |old: &Vec<[f32; 3]>| {
                    (0..h).all(|y| old[row(y)].iter().map(bits).eq(picture[row(y)].iter().map(bits)))
                };
                if !shown.as_ref().is_some_and(same) {
                    let data = (0..h).flat_map(|y| picture[row(y)].iter().flatten().copied());
                    self.square([left, top, w, h], data)?;
                }
            }
        }
        self.shown = Some(picture.to_vec());
        Ok(())
    }

    fn square(&mut self, place: [u32; 4], data: impl Iterator<Item = f32>) -> io::Result<()> {
        let mut body = self.head(6, false);
        body.extend(3i32.to_le_bytes());
        CHANNELS.iter().for_each(|name| put_text(&mut body, name));
        place.iter().for_each(|number| body.extend(number.to_le_bytes()));
        (0i64..3).for_each(|start| body.extend(start.to_le_bytes()));
        (0..3).for_each(|_| body.extend(3i64.to_le_bytes()));
        data.for_each(|value| body.extend(value.to_le_bytes()));
        self.send(body)
    }

    fn head(&self, kind: u8, front: bool) -> Vec<u8> {
        let mut body = vec![0, 0, 0, 0, kind, u8::from(front)];
        put_text(&mut body, &self.name);
        body
    }

    fn send(&mut self, mut message: Vec<u8>) -> io::Result<()> {
        let length = u32::try_from(message.len()).map_err(|e| io::Error::new(io::ErrorKind::InvalidInput, e))?;
        message[..4].copy_from_slice(&length.to_le_bytes());
        self.stream.write_all(&message)
    }
}

const CHANNELS: [&str; 3] = ["R", "G", "B"];

fn put_text(message: &mut Vec<u8>, text: &str) {
    message.extend(text.bytes());
    message.push(0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;
    use std::net::TcpListener;

    /// Takes a message apart as the viewer does.
    struct Message(std::vec::IntoIter<u8>);

    impl Message {
        fn read(stream: &mut TcpStream) -> Option<Self> {
            let mut length = [0; 4];
            stream.read_exact(&mut length).ok()?;
            let mut body = vec![0; u32::from_le_bytes(length) as usize - 4];
            stream.read_exact(&mut body).unwrap();
            Some(Self(body.into_iter()))
        }

        fn take<const N: usize>(&mut self) -> [u8; N] {
            std::array::from_fn(|_| self.0.next().unwrap())
        }

        fn text(&mut self) -> String {
            String::from_utf8(self.0.by_ref().take_while(|&b| b != 0).collect()).unwrap()
        }

        fn int(&mut self) -> i32 {
            i32::from_le_bytes(self.take())
        }
    }

    /// A viewer that puts together what it is sent, and counts the updates.
    fn serve(listener: &TcpListener) -> (Vec<[f32; 3]>, usize) {
        let (mut stream, _) = listener.accept().unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        let mut create = Message::read(&mut stream).unwrap();
        assert_eq!((create.take(), create.text()), ([4, 1], "milk".into()));
        let (width, height) = (create.int(), create.int());
        assert_eq!((width, height, create.int()), (100, 70, 3));
        assert_eq!([create.text(), create.text(), create.text()], ["R", "G", "B"]);
        assert_eq!(create.0.len(), 0);
        let (mut picture, mut updates) = (vec![[f32::NAN; 3]; (width * height) as usize], 0);
        while let Some(mut update) = Message::read(&mut stream) {
            updates += 1;
            assert_eq!((update.take(), update.text(), update.int()), ([6, 0], "milk".into(), 3));
            assert_eq!([update.text(), update.text(), update.text()], ["R", "G", "B"]);
            let [x, y, w, h] = std::array::from_fn(|_| update.int());
            let mut longs = || -> [i64; 3] { std::array::from_fn(|_| i64::from_le_bytes(update.take())) };
            let (starts, strides) = (longs(), longs());
            let data: Vec<f32> = (0..3 * w * h).map(|_| f32::from_le_bytes(update.take())).collect();
            assert_eq!(update.0.len(), 0);
            for i in 0..w * h {
                let at = ((y + i / w) * width + x + i % w) as usize;
                picture[at] = std::array::from_fn(|c| data[(starts[c] + i64::from(i) * strides[c]) as usize]);
            }
        }
        (picture, updates)
    }

    #[test]
    fn what_a_viewer_puts_together_is_the_picture() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let server = std::thread::spawn(move || serve(&listener));
        let mut picture: Vec<[f32; 3]> = (0..7000u16).map(|i| [f32::from(i), 0.5, -f32::from(i)]).collect();
        let mut viewer = Viewer::open(&address, "milk", [100, 70]).unwrap();
        viewer.update(&picture).unwrap();
        picture[6999] = [1.0, 2.0, 3.0];
        viewer.update(&picture).unwrap();
        assert!(viewer.update(&picture[1..]).is_err());
        drop(viewer);
        // Four squares at first, then the one that has changed.
        assert_eq!(server.join().unwrap(), (picture, 5));
    }

    #[test]
    fn nobody_at_home_is_an_error() {
        let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
        for address in [free.as_str(), "nowhere", ""] {
            assert!(matches!(Viewer::open(address, "x", [1, 1]), Err(TevError::Connect { .. })), "{address}");
        }
    }
}
