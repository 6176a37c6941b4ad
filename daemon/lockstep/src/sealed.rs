//! Memory as a file that has no name and a size that nobody can change: whoever maps it can rely on its
//! pages, whatever the process at the other end does.

use std::fs::File;
use std::io;
use std::os::fd::OwnedFd;

use rustix::fs::{
    MemfdFlags, SealFlags, fcntl_add_seals, fcntl_get_seals, ftruncate, memfd_create,
};
use rustix::io::Errno;

/// Makes a file of so many bytes, all zero; `/proc/PID/maps` shows it under this name.
///
/// # Errors
/// There is no memory, or no descriptor, left.
pub fn sealed(name: &str, size: u64) -> io::Result<File> {
    let flags = MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING;
    // Nothing in it is to be executed; kernels before 6.3 cannot be told so.
    let file = match memfd_create(name, flags | MemfdFlags::NOEXEC_SEAL) {
        Err(Errno::INVAL) => memfd_create(name, flags)?,
        made => made?,
    };
    ftruncate(&file, size)?;
    fcntl_add_seals(&file, seals())?;
    Ok(File::from(file))
}

/// Takes a file that another process made, if it is of so many bytes and stays so.
///
/// # Errors
/// It is another file: to map it could end whoever looks there when its size changes.
pub fn checked(file: OwnedFd, size: u64) -> io::Result<File> {
    let file = File::from(file);
    let is = file.metadata()?.len();
    if is != size || !fcntl_get_seals(&file)?.contains(seals()) {
        let message = format!("it is no memory of {size} bytes whose size stays");
        return Err(io::Error::new(io::ErrorKind::InvalidData, message));
    }
    Ok(file)
}

fn seals() -> SealFlags {
    SealFlags::SHRINK | SealFlags::GROW | SealFlags::SEAL
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_whose_size_can_change_is_not_taken() {
        let taken = |file: OwnedFd| checked(file, 64).map_err(|error| error.kind()).err();
        for seals in [SealFlags::empty(), SealFlags::SHRINK, SealFlags::SHRINK | SealFlags::GROW] {
            let file = memfd_create("test", MemfdFlags::ALLOW_SEALING).unwrap();
            ftruncate(&file, 64).unwrap();
            fcntl_add_seals(&file, seals).unwrap();
            assert_eq!(taken(file), Some(io::ErrorKind::InvalidData), "{seals:?}");
        }
        let on_disk = tempfile::tempfile().unwrap();
        on_disk.set_len(64).unwrap();
        assert!(taken(on_disk.into()).is_some());
        assert!(taken(io::pipe().unwrap().0.into()).is_some());
        let ours = sealed("test", 64).unwrap();
        assert!(ours.set_len(65).is_err() && ours.set_len(63).is_err());
        assert!(checked(ours.try_clone().unwrap().into(), 63).is_err());
        assert_eq!(taken(ours.into()), None);
    }
}
