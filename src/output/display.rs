//! The image so far in a viewer that listens on a port, by the protocol of tev (github.com/Tom94/tev).
//!
//! A thread of its own sends. It takes the newest image there is, so that a viewer that is slow misses images and delays no render.

use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::Duration;

use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

/// How long a viewer may take to answer, or to read anything.
const PATIENCE: Duration = Duration::from_secs(2);
/// How long the end of a render waits for a viewer that reads slowly.
const LONGEST_END: Duration = Duration::from_secs(10);
/// The channels of a pixel, in this order.
const CHANNELS: [&str; 3] = ["R", "G", "B"];
/// The numbers in a packet: 1 MiB, or one row if that is more.
const MOST_NUMBERS: usize = 1 << 18;

/// A viewer that is sent images.
pub struct Display(Arc<Shared>);

#[derive(Default)]
struct Shared {
    state: Mutex<Outbox>,
    changed: Condvar,
}

#[derive(Default)]
struct Outbox {
    /// The newest image, until it is sent.
    image: Option<Vec<f32>>,
    /// Whether no image comes after it.
    last: bool,
    /// How the sending has ended.
    end: Option<io::Result<()>>,
}

impl Display {
    /// Has the viewer at `HOST:PORT` show a black image of this name and size.
    pub fn open(address: String, name: String, size: (u32, u32)) -> Display {
        let shared = Arc::<Shared>::default();
        let theirs = shared.clone();
        let send = move || {
            let end = theirs.send_all(&address, &name, size);
            theirs.change(|state| state.end = Some(end));
        };
        if let Err(error) = Builder::new().name("display".to_owned()).spawn(send) {
            shared.change(|state| state.end = Some(Err(error)));
        }
        Display(shared)
    }

    /// Whether images still arrive.
    pub fn is_open(&self) -> bool {
        self.0.state().end.is_none()
    }

    /// Sends an image, row 0 on top, red, green and blue of a pixel together. Does not wait.
    pub fn show(&self, image: Vec<f32>) {
        self.0.change(|state| state.image = Some(image));
    }

    /// Sends what there is, and waits until the viewer has it or has failed.
    pub fn close(&self) {
        self.0.change(|state| state.last = true);
        let waiting = |state: &mut Outbox| state.end.is_none();
        let waited = self.0.changed.wait_timeout_while(self.0.state(), LONGEST_END, waiting);
        let (mut state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        state.end.get_or_insert_with(|| Err(io::ErrorKind::TimedOut.into()));
    }

    /// Why images do not arrive. Told once.
    pub fn failure(&self) -> Option<String> {
        let error = self.0.state().end.as_mut().and_then(|end| std::mem::replace(end, Ok(())).err())?;
        Some(match error.kind() {
            io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut => "it does not read".to_owned(),
            _ => error.to_string(),
        })
    }
}

impl Shared {
    /// A poisoned lock still holds a state.
    fn state(&self) -> MutexGuard<'_, Outbox> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, change: impl FnOnce(&mut Outbox)) {
        change(&mut self.state());
        self.changed.notify_all();
    }

    /// The newest image, when there is one; nothing after the last.
    fn next(&self) -> Option<Vec<f32>> {
        let waiting = |state: &mut Outbox| state.image.is_none() && !state.last;
        let waited = self.changed.wait_while(self.state(), waiting);
        waited.unwrap_or_else(PoisonError::into_inner).image.take()
    }

    /// Sends each image that comes.
    fn send_all(&self, address: &str, name: &str, (width, height): (u32, u32)) -> io::Result<()> {
        let socket = connect(address)?;
        socket.set_write_timeout(Some(PATIENCE))?;
        let mut client = TevClient::wrap(socket);
        // An image that the viewer has by this name is replaced.
        client.send(PacketCreateImage {
            image_name: name,
            grab_focus: true,
            width,
            height,
            channel_names: &CHANNELS,
        })?;
        while let Some(image) = self.next() {
            send(&mut client, name, width, &image)?;
        }
        Ok(())
    }
}

/// Sends an image of a name and a width in bands of whole rows.
fn send(client: &mut TevClient, image_name: &str, width: u32, image: &[f32]) -> io::Result<()> {
    let row = CHANNELS.len() * width.max(1) as usize;
    let mut y = 0;
    for band in image.chunks(row * (MOST_NUMBERS / row).max(1)) {
        let height = (band.len() / row) as u32;
        client.send(PacketUpdateImage {
            image_name,
            grab_focus: false,
            channel_names: &CHANNELS,
            channel_offsets: &[0, 1, 2],
            channel_strides: &[3; 3],
            x: 0,
            y,
            width,
            height,
            data: band,
        })?;
        y += height;
    }
    Ok(())
}

/// A connection to the first of the host's addresses that answers.
fn connect(address: &str) -> io::Result<TcpStream> {
    let mut failed = io::Error::other("the host has no address");
    for address in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, PATIENCE) {
            Ok(socket) => return Ok(socket),
            Err(error) => failed = error,
        }
    }
    Err(failed)
}
