//! Tags of arrays in VTK's XML.

use super::xml_attribute;

/// Arrays of the file as a whole.
pub(super) fn field_arrays(arrays: &[(String, Vec<i32>)]) -> String {
    let array = |(name, numbers): &(String, Vec<i32>)| {
        let text = numbers.iter().map(i32::to_string).collect::<Vec<_>>().join(" ");
        let (name, count) = (xml_attribute(name), numbers.len());
        format!(
            "<DataArray type=\"Int32\" Name=\"{name}\" NumberOfTuples=\"{count}\" format=\"ascii\">{text}</DataArray>\n"
        )
    };
    arrays.iter().map(array).collect()
}

/// The section of arrays of the file as a whole; nothing without any.
pub(super) fn field_data(arrays: &str) -> String {
    if arrays.is_empty() { String::new() } else { format!("<FieldData>\n{arrays}</FieldData>\n") }
}

/// The tag of an appended array.
pub(super) fn tag(name: &str, kind: &str, components: usize, offset: usize) -> String {
    format!(
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" \
         offset=\"{offset}\"/>\n"
    )
}
