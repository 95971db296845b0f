//! Splits a joint's name into known words.

use super::vocabulary::{JAPANESE, VOCABULARY, Word};

/// Returns the known words of `name`, in order; unknown words and words without meaning are left out.
pub(super) fn words(name: &str) -> Vec<Word> {
    // The text before the last of these characters is the name of the file or the character. Poser appends a
    // number, to which exporters add `_jnt`.
    let name = name.rsplit([':', '|']).find(|part| names_a_joint(part)).unwrap_or(name);
    if is_vertebra(name) {
        return vec![Word::Spine];
    }
    let mut name = name.to_owned();
    for (japanese, english) in JAPANESE {
        name = name.replace(japanese, english);
    }
    let tokens = tokens(&name);
    let side_stands_alone =
        tokens.iter().any(|token| matches!(token.as_str(), "l" | "r" | "left" | "right"));
    let known = tokens.iter().filter_map(|token| in_words(token, side_stands_alone)).flatten();
    known.filter(|word| *word != Word::Noise).collect()
}

/// Returns whether part of a name contains more than words without meaning, such as joint.
fn names_a_joint(part: &str) -> bool {
    let is_noise = |token: &String| {
        in_words(token, false).is_some_and(|words| words.iter().all(|word| *word == Word::Noise))
    };
    !tokens(part).iter().all(is_noise)
}

/// Returns whether a name denotes a vertebra, although its `L` could mean a left side: `L5`, `T12`, `jL5S1`.
fn is_vertebra(name: &str) -> bool {
    let name = name.strip_prefix('j').unwrap_or(name);
    let mut digits = 0;
    for letter in name.chars().rev() {
        match letter {
            '0'..='9' if digits < 2 => digits += 1,
            'L' | 'T' | 'C' | 'S' if digits > 0 => digits = 0,
            _ => return false,
        }
    }
    digits == 0 && !name.is_empty()
}

/// Splits a name at punctuation, digits and changes of case, in lower case: `LHipJoint` is `l`, `hip`, `joint`.
fn tokens(name: &str) -> Vec<String> {
    let letters: Vec<char> = name.chars().collect();
    let mut tokens = Vec::new();
    let mut token = String::new();
    for (place, letter) in letters.iter().enumerate() {
        let before = place.checked_sub(1).map(|before| letters[before]);
        let next_is_lower = letters.get(place + 1).is_some_and(|next| next.is_lowercase());
        let begins = letter.is_uppercase()
            && before.is_some_and(|before| {
                before.is_lowercase() || (before.is_uppercase() && next_is_lower)
            });
        if begins || !letter.is_alphabetic() {
            tokens.push(std::mem::take(&mut token));
        }
        if letter.is_alphabetic() {
            token.extend(letter.to_lowercase());
        }
    }
    tokens.push(token);
    tokens.retain(|token| !token.is_empty());
    tokens
}

/// Splits a token into known words that cover all of it: `lhipjoint` is left, hip, joint. Uses the split with the
/// fewest words. Returns `None` if there is no such split.
fn in_words(token: &str, side_is_known: bool) -> Option<Vec<Word>> {
    if !token.is_ascii() {
        return None;
    }
    // For each number of first letters, their best cover by words.
    let mut covers: Vec<Option<Vec<Word>>> = vec![None; token.len() + 1];
    covers[0] = Some(Vec::new());
    for from in 0..token.len() {
        let Some(cover) = covers[from].clone() else { continue };
        let rest = &token[from..];
        let spelled = VOCABULARY
            .iter()
            .flat_map(|(word, spellings)| spellings.iter().map(move |spelling| (*word, *spelling)))
            .filter(|(_, spelling)| {
                rest.starts_with(spelling) && (spelling.len() > 1 || from == 0)
            });
        for (word, length) in
            spelled.map(|(word, s)| (word, s.len())).chain(letter(rest, from, token, side_is_known))
        {
            let place = from + length;
            if covers[place].as_ref().is_none_or(|other| other.len() > cover.len() + 1) {
                covers[place] = Some(cover.iter().copied().chain([word]).collect());
            }
        }
    }
    covers.pop().flatten()
}

/// Returns the word that the first letter of `rest` means, and its length, 1: at the beginning or the end of a token
/// `l` and `r` mean a side; `u` and `f` mean upper and fore, as in `LUArm`, `LFArm`. If the side is already known, `l`
/// means lower. Returns `None` for other letters.
fn letter(rest: &str, from: usize, token: &str, side_is_known: bool) -> Option<(Word, usize)> {
    let at_edge = from == 0 || rest.len() == 1;
    let word = match rest.as_bytes().first()? {
        b'l' if side_is_known && token.len() > 1 => Word::Lower,
        b'l' if at_edge => Word::Left,
        b'r' if at_edge => Word::Right,
        b'u' => Word::Upper,
        b'f' if from > 0 => Word::Fore,
        _ => return None,
    };
    Some((word, 1))
}

#[cfg(test)]
mod tests {
    use super::super::vocabulary::Word::*;
    use super::words;

    #[test]
    fn names_are_cut_into_words() {
        for (name, expected) in [
            ("mixamorig7:LeftUpLeg", vec![Left, Upper, Leg]),
            ("LHipJoint", vec![Left, Hip]),
            ("lhipjoint", vec![Left, Hip]),
            ("LEFTUPLEG", vec![Left, Upper, Leg]),
            ("J_Bip_L_UpperLeg", vec![Left, Upper, Leg]),
            ("Bip01 R Forearm", vec![Right, Fore, Arm]),
            ("l_up_arm", vec![Left, Upper, Arm]),
            ("LUArm", vec![Left, Upper, Arm]),
            ("l_larm", vec![Left, Lower, Arm]),
            ("hand_r", vec![Hand, Right]),
            ("rMid1", vec![Right, Middle]),
            ("mHipLeft", vec![Hip, Left]),
            ("mhipleft", vec![Hip, Left]),
            ("L5", vec![Spine]),
            ("jL5S1", vec![Spine]),
            ("lThigh:12", vec![Left, Thigh]),
            ("lThigh:12_jnt", vec![Left, Thigh]),
            ("Actor:joint_12", vec![]),
            ("mixamorigleftarm", vec![Left, Arm]),
            ("左ひじ", vec![Left, Elbow]),
            ("lShldr", vec![Left, UpperArm]),
            ("ValveBiped.Bip01_L_Calf", vec![Left, Shank]),
            ("DEF-upper_arm.L.001", vec![Upper, Arm, Left]),
            ("joint_12", vec![]),
            ("root", vec![Root]),
        ] {
            assert_eq!(words(name), expected, "{name}");
        }
    }
}
