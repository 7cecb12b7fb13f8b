//! Messages between processes: sums, and exchange of entries of vectors.

use std::ffi::c_int;
use std::sync::Arc;

use rigid::SumOverParts;

use super::session::world;
use super::{Session, Vector};
use crate::PetscError;
use crate::ffi;

/// Numbers that one message of a sum over processes has at most, 512 KiB.
const MAX_SUM_LENGTH: usize = 1 << 16;

impl Session {
    /// Replaces numbers by their sums over all processes, in the order of the processes.
    ///
    /// Every process calls it with equally many numbers. The sums are the same on all.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn sum(&self, values: &mut [f64]) -> Result<(), PetscError> {
        for block in values.chunks_mut(MAX_SUM_LENGTH) {
            let mut own = Vector::new(self, block.len())?;
            own.set(block)?;
            let all = own.of_all()?;
            block.fill(0.0);
            for of_process in all.chunks_exact(block.len()) {
                (block.iter_mut().zip(of_process)).for_each(|(sum, value)| *sum += value);
            }
        }
        Ok(())
    }

    /// Sum of `count` over the processes before this one.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn before(&self, count: usize) -> Result<usize, PetscError> {
        let mut counts = vec![0.0; self.ranks()];
        counts[self.rank()] = count as f64;
        self.sum(&mut counts)?;
        Ok(counts[..self.rank()]
            .iter()
            .map(|count| *count as usize)
            .sum())
    }

    /// [`Session::sum`] in the form that the crate `rigid` takes.
    ///
    /// On another thread, after the end of the session or after an error it writes NaN.
    pub fn sum_over_parts(&self) -> SumOverParts {
        Arc::new(|values: &mut [f64]| {
            if Self::with_current(|session| session.sum(values)).is_err() {
                values.fill(f64::NAN);
            }
        })
    }
}

/// The entries of a vector that this process sends to others, and those that it receives.
pub struct Exchange {
    sent: Entries,
    received: Entries,
}

/// Positions in a vector, by process.
struct Entries {
    positions: Vec<u32>,
    counts: Vec<c_int>,
    starts: Vec<c_int>,
}

impl Entries {
    fn new(of_processes: &[Vec<u32>]) -> Result<Self, PetscError> {
        let (mut counts, mut starts) = (Vec::new(), vec![0]);
        for positions in of_processes {
            counts.push(small(positions.len())?);
            let so_far = starts[starts.len() - 1] as usize;
            starts.push(small(so_far + positions.len())?);
        }
        Ok(Self {
            positions: of_processes.concat(),
            counts,
            starts,
        })
    }
}

/// A number as MPI's count.
fn small(found: usize) -> Result<c_int, PetscError> {
    c_int::try_from(found).map_err(|_| PetscError::TooLarge {
        what: "entries that two processes exchange",
        found,
        bits: c_int::BITS,
    })
}

impl Exchange {
    /// Sends the entries `sent[p]` to process `p`, which receives them in this order.
    ///
    /// The entries `received[p]` come from process `p`. Collective.
    ///
    /// # Errors
    /// [`PetscError::TooLarge`].
    pub fn new(sent: &[Vec<u32>], received: &[Vec<u32>]) -> Result<Self, PetscError> {
        Ok(Self {
            sent: Entries::new(sent)?,
            received: Entries::new(received)?,
        })
    }

    /// Replaces the received entries of `vector`.
    ///
    /// # Errors
    /// Those of PETSc and MPI.
    ///
    /// # Panics
    /// If the vector is shorter than the positions.
    pub fn update(&self, session: &Session, vector: &mut [f64]) -> Result<(), PetscError> {
        let (sent, received) = (&self.sent, &self.received);
        let outgoing = sent.positions.iter().map(|&entry| vector[entry as usize]);
        let outgoing: Vec<f64> = outgoing.collect();
        let mut incoming = vec![0.0; received.positions.len()];
        debug_assert_eq!(sent.counts.len(), session.ranks());
        let mut double = ffi::NO_DATATYPE;
        // SAFETY: the result is live; the type is one that every MPI has.
        unsafe { call!(PetscDataTypeToMPIDataType(ffi::PETSC_DOUBLE, &mut double)) }?;
        // SAFETY: counts and starts have one entry per process. The counts sum to the lengths of
        // `outgoing` and `incoming`, and the starts are their partial sums. Both arrays live until
        // the call returns.
        unsafe {
            call!(MPI_Alltoallv(
                outgoing.as_ptr().cast(),
                sent.counts.as_ptr(),
                sent.starts.as_ptr(),
                double,
                incoming.as_mut_ptr().cast(),
                received.counts.as_ptr(),
                received.starts.as_ptr(),
                double,
                world()
            ))
        }?;
        for (&entry, value) in received.positions.iter().zip(incoming) {
            vector[entry as usize] = value;
        }
        Ok(())
    }
}
