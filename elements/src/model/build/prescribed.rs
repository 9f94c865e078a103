//! Coordinates with prescribed motions, and those that maps reparametrize.

use crate::model::build::builder::NodeId;
use crate::model::{ElementEntry, ModelError, Node, NodeForm, Prescribed, Subject, among};
use crate::time::TimeFunction;
use std::collections::HashSet;
use std::sync::Arc;

/// Frames with an entirely prescribed rotation.
pub(in crate::model) fn prescribed_rotations(
    nodes: &[Node],
    prescribed: &[Prescribed],
) -> Vec<usize> {
    let turned = |n: &usize| {
        let first = nodes[*n].first;
        nodes[*n].is_frame() && among(prescribed, first + 3..first + 6).len() == 3
    };
    (0..nodes.len()).filter(turned).collect()
}

/// Checks that reparametrized coordinates are free, and used by no other map or element.
pub(in crate::model) fn check_reparametrized(
    nodes: &[Node],
    elements: &[ElementEntry],
    prescribed: &[Prescribed],
) -> Result<(), ModelError> {
    for (n, node) in nodes.iter().enumerate() {
        let Some(d) = node.mapped().filter(|d| d.reparametrizes) else {
            continue;
        };
        // Parents after the first are parameters, which are not reparametrized.
        let Some(&m) = d.initial_parents().first() else {
            continue;
        };
        let parent = &nodes[m as usize];
        // Created for the frame by the model itself.
        if parent.form == NodeForm::Increment {
            continue;
        }
        let reads = |k: usize| nodes[k].all_parents().any(|x| x == m);
        let element = elements.iter().find(|e| e.nodes.contains(&m));
        let other = (0..nodes.len()).find(|&k| k != n && reads(k));
        let held = prescribed
            .iter()
            .any(|p| parent.range().contains(&p.coordinate));
        let user = if let Some(e) = element {
            format!("element {}", e.name)
        } else if let Some(k) = other {
            format!("the joint at {}", nodes[k].name)
        } else if held {
            "a support or prescribed motion".to_owned()
        } else if !parent.is_own() || parent.form != NodeForm::Coordinates {
            "a joint with other parents".to_owned()
        } else {
            continue;
        };
        return Err(ModelError::Reparametrized {
            node: node.name.clone(),
            coordinates: parent.name.clone(),
            user,
        });
    }
    Ok(())
}

/// The prescribed coordinates.
pub(in crate::model) fn resolve_prescribed(
    nodes: &[Node],
    prescribed: Vec<(NodeId, usize, Arc<dyn TimeFunction>)>,
) -> Result<Vec<Prescribed>, ModelError> {
    let mut out: Vec<Prescribed> = Vec::with_capacity(prescribed.len());
    let mut taken = HashSet::new();
    for (id, dof, function) in prescribed {
        let node = &nodes[id.0 as usize];
        if dof >= node.dim {
            return Err(ModelError::NoCoordinate {
                node: node.name.clone(),
                coordinate: dof.saturating_add(1),
                dim: node.dim,
            });
        }
        let coordinate = Subject::coordinate(nodes, id.0, dof);
        if !node.is_own() {
            return Err(refuse_mapped(nodes, id.0, coordinate));
        }
        if !taken.insert(node.first + dof) {
            return Err(ModelError::PrescribedTwice { coordinate });
        }
        out.push(Prescribed {
            coordinate: node.first + dof,
            function,
        });
    }
    Ok(out)
}

/// Error for a prescribed coordinate that follows from others; it names those that can be
/// prescribed instead.
fn refuse_mapped(nodes: &[Node], dependent: u32, coordinate: Subject) -> ModelError {
    let (mut waiting, mut own) = (vec![dependent], Vec::new());
    while let Some(n) = waiting.pop() {
        let node = &nodes[n as usize];
        match node.mapped() {
            Some(d) if d.reparametrizes => {
                let solved = node.name.clone();
                return ModelError::PrescribedSolved { coordinate, solved };
            }
            // In the order of the parents.
            Some(d) => waiting.extend(d.initial_parents().iter().rev()),
            None if own.contains(&node.name.as_str()) => {}
            None => own.push(&node.name),
        }
    }
    let parents = own.join(", ");
    ModelError::PrescribedDependent {
        coordinate,
        parents,
    }
}
