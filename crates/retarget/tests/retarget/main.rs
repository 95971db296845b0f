//! Tests of clips on skeletons and rigs of any kind.

mod mappings_page;
mod on_rigs;
mod page;
mod skeleton_dialects;
mod skeleton_files;
mod skeleton_maps;
mod skeleton_others;
