//! Arrays in and out. What comes in may be anything that numpy makes an array of; what goes out is a copy that cannot
//! be written to, since a change of it would not reach the engine.

use canopy_fem::model::spec::SpringValues;
use numpy::{Element, PyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArray};
use numpy::{PyUntypedArrayMethods, ndarray::Dimension};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// The array, which cannot be written to from now on.
pub(crate) fn read_only<T: Element, D: Dimension>(array: Bound<'_, PyArray<T, D>>) -> Bound<'_, PyArray<T, D>> {
    // It is new, so nobody else holds it.
    if let Ok(write) = array.try_readwrite() {
        drop(write.make_nonwriteable());
    }
    array
}

/// Numbers, shape (n,), read-only.
pub(crate) fn of_list<T: Element>(py: Python<'_>, list: Vec<T>) -> Bound<'_, PyArray1<T>> {
    read_only(PyArray1::from_vec(py, list))
}

/// Rows of three numbers, shape (n, 3), read-only.
pub(crate) fn of_rows<'py>(py: Python<'py>, rows: Vec<[f64; 3]>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    own_rows(py, rows).map(read_only)
}

/// The same, for the caller to write to.
fn own_rows<'py>(py: Python<'py>, rows: Vec<[f64; 3]>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let shape = [rows.len(), 3];
    PyArray1::from_vec(py, rows.into_flattened()).reshape(shape)
}

/// Numbers of nodes, edges or triangles, shape (n,), read-only: int64, numpy's own type of indices.
pub(crate) fn of_indices<'py>(py: Python<'py>, list: &[u32]) -> Bound<'py, PyArray1<i64>> {
    of_list(py, list.iter().copied().map(i64::from).collect())
}

/// Node numbers, shape (n, N), read-only.
pub(crate) fn of_numbers<'py, const N: usize>(
    py: Python<'py>,
    rows: &[[u32; N]],
) -> PyResult<Bound<'py, PyArray2<i64>>> {
    let numbers = rows.as_flattened().iter().copied().map(i64::from).collect();
    PyArray1::from_vec(py, numbers).reshape([rows.len(), N]).map(read_only)
}

/// A value as an array of numbers of `kinds` (numpy's letters), with a shape that is checked before anything is copied.
fn array<'py>(
    value: &Bound<'py, PyAny>,
    what: &str,
    kinds: &str,
    shape: impl FnOnce(&[usize]) -> Result<(), String>,
) -> PyResult<Bound<'py, PyUntypedArray>> {
    let py = value.py();
    let made = py.import("numpy")?.call_method1("asarray", (value,));
    let made = made.map_err(|error| PyValueError::new_err(format!("{what} is no array of numbers: {error}")))?;
    let array = made.cast_into::<PyUntypedArray>()?;
    let kind: String = array.dtype().getattr("kind")?.extract()?;
    if array.len() > 0 && !kinds.contains(&kind) {
        let wanted = if kinds.contains('f') { "real numbers" } else { "whole numbers" };
        return Err(PyTypeError::new_err(format!("{what} must be {wanted}, and is of type {}", array.dtype())));
    }
    shape(array.shape()).map_err(|wanted| {
        PyValueError::new_err(format!("{what} must have the shape {wanted}, and has {:?}", array.shape()))
    })?;
    Ok(array)
}

/// Rows of three finite or other numbers; `needed` rows if that is given. Any real type, any strides.
///
/// # Errors
/// `TypeError` for other types, `ValueError` for another shape.
pub(crate) fn rows(value: &Bound<'_, PyAny>, what: &str, needed: Option<usize>) -> PyResult<Vec<[f64; 3]>> {
    if let Ok(array) = value.cast::<PyArray2<f64>>() {
        let read = array.try_readonly().map_err(|error| PyValueError::new_err(format!("{what}: {error}")))?;
        if array.is_c_contiguous()
            && let Ok(numbers) = read.as_slice()
            && array.shape()[1] == 3
            && needed.is_none_or(|n| n == array.shape()[0])
        {
            return Ok(numbers.as_chunks::<3>().0.to_vec());
        }
    }
    let right = |shape: &[usize]| match (shape, needed) {
        (&[n, 3], Some(needed)) if n == needed => Ok(()),
        (&[_, 3], None) => Ok(()),
        (_, Some(n)) => Err(format!("({n}, 3)")),
        (_, None) => Err("(n, 3)".to_owned()),
    };
    let array = array(value, what, "biuf", right)?;
    let plain = contiguous(&array, "float64")?;
    let read: PyReadonlyArray2<'_, f64> = plain.extract()?;
    let numbers = read.as_slice().map_err(|error| PyValueError::new_err(error.to_string()))?;
    Ok(numbers.as_chunks::<3>().0.to_vec())
}

/// `needed` numbers, given as one or as all of them.
///
/// # Errors
/// As [`rows`].
pub(crate) fn numbers(value: &Bound<'_, PyAny>, what: &str, needed: usize) -> PyResult<Vec<f64>> {
    Ok(spring_values(value, what, needed)?.of(needed).collect())
}

/// Numbers of `needed` springs, one for all or one each.
///
/// # Errors
/// As [`rows`].
pub(crate) fn spring_values(value: &Bound<'_, PyAny>, what: &str, needed: usize) -> PyResult<SpringValues> {
    let right = |shape: &[usize]| match shape {
        [] => Ok(()),
        &[n] if n == needed => Ok(()),
        _ => Err(format!("({needed},) or be one number")),
    };
    let array = array(value, what, "biuf", right)?;
    let list: Vec<f64> = contiguous(&array, "float64")?.call_method0("ravel")?.call_method0("tolist")?.extract()?;
    Ok(if array.ndim() == 0 { list[0].into() } else { list.into() })
}

/// Three finite or other numbers.
///
/// # Errors
/// As [`rows`].
pub(crate) fn vector(value: &Bound<'_, PyAny>, what: &str) -> PyResult<[f64; 3]> {
    let right = |shape: &[usize]| if shape == [3] { Ok(()) } else { Err("(3,)".to_owned()) };
    contiguous(&array(value, what, "biuf", right)?, "float64")?.call_method0("tolist")?.extract()
}

/// Whole numbers from 0, e.g. of nodes: shape (n,).
///
/// # Errors
/// As [`rows`]; also numbers below 0 or beyond 32 bits.
pub(crate) fn indices(value: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<u32>> {
    let right = |shape: &[usize]| if shape.len() == 1 { Ok(()) } else { Err("(n,)".to_owned()) };
    whole(&array(value, what, "iu", right)?, what)
}

/// Rows of whole numbers from 0: shape (n, N).
///
/// # Errors
/// As [`indices`].
pub(crate) fn index_rows<const N: usize>(value: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<[u32; N]>> {
    let right = |shape: &[usize]| match shape {
        [0] => Ok(()),
        &[_, columns] if columns == N => Ok(()),
        _ => Err(format!("(n, {N})")),
    };
    Ok(whole(&array(value, what, "iu", right)?, what)?.as_chunks::<N>().0.to_vec())
}

fn whole(array: &Bound<'_, PyUntypedArray>, what: &str) -> PyResult<Vec<u32>> {
    if array.len() == 0 {
        return Ok(Vec::new());
    }
    let list = array.call_method0("ravel")?.call_method0("tolist")?;
    list.extract().map_err(|_| PyValueError::new_err(format!("{what} must be numbers from 0 to {}", u32::MAX)))
}

/// The same numbers in a row, in C's order and aligned.
fn contiguous<'py>(array: &Bound<'py, PyUntypedArray>, dtype: &str) -> PyResult<Bound<'py, PyAny>> {
    array.py().import("numpy")?.call_method1("require", (array, dtype, ["C", "A"]))
}

/// Fills `out`, or a new array, with `n` rows that `fill` writes.
///
/// # Errors
/// An `out` that is not a writable C-contiguous array of float64 with shape (n, 3).
pub(crate) fn filled<'py>(
    py: Python<'py>,
    n: usize,
    out: Option<&Bound<'py, PyAny>>,
    fill: impl FnOnce(&mut [[f64; 3]]) -> PyResult<()>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let Some(out) = out else {
        let mut rows = vec![[0.0; 3]; n];
        fill(&mut rows)?;
        return own_rows(py, rows);
    };
    let array = out.cast::<PyArray2<f64>>();
    let array = array.map_err(|_| PyTypeError::new_err("out must be an array of float64 with two dimensions"))?;
    if array.shape() != [n, 3] {
        let found = array.shape();
        return Err(PyValueError::new_err(format!("out must have the shape ({n}, 3), and has {found:?}")));
    }
    if !array.is_c_contiguous() {
        return Err(PyValueError::new_err("out must be C-contiguous"));
    }
    let mut write = array.try_readwrite().map_err(|error| PyValueError::new_err(format!("out: {error}")))?;
    let place = write.as_slice_mut();
    fill(place.map_err(|_| PyValueError::new_err("out must be aligned"))?.as_chunks_mut::<3>().0)?;
    Ok(array.clone())
}
