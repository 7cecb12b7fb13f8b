//! Serde and the lists of words agree.

use serde::de::DeserializeOwned;

use super::*;

/// Every word of the list is read by serde as the variant that has this word, and written back.
fn check<T>(words: &[&'static str])
where
    T: Copy + Serialize + DeserializeOwned + Into<&'static str>,
{
    for &word in words {
        let text = toml::Value::String(word.to_owned());
        let kind: T = text.clone().try_into().unwrap();
        assert_eq!(kind.into(), word);
        assert_eq!(toml::Value::try_from(kind).unwrap(), text);
    }
}

#[test]
fn serde_and_the_lists_of_words_agree() {
    check::<DomainKind>(DomainKind::WORDS);
    check::<ShapeKind>(ShapeKind::WORDS);
    check::<ArmsKind>(ArmsKind::WORDS);
    check::<JointWord>(JointWord::WORDS);
    check::<DriveKind>(DriveKind::WORDS);
    check::<GaitKind>(GaitKind::WORDS);
    check::<InterpolationKind>(InterpolationKind::WORDS);
    check::<ModelKind>(ModelKind::WORDS);
    check::<AcceptKind>(AcceptKind::WORDS);
    check::<FormulationKind>(FormulationKind::WORDS);
    check::<SolverKind>(SolverKind::WORDS);
    check::<MeshMotionKind>(MeshMotionKind::WORDS);
    check::<MesherKind>(MesherKind::WORDS);
    check::<GeometryKind>(GeometryKind::WORDS);
    check::<SymmetryKind>(SymmetryKind::WORDS);
    check::<EstimatesKind>(EstimatesKind::WORDS);
    check::<crate::FlowsKind>(crate::FlowsKind::WORDS);
}
