//! What a line is for: its name in the file, its flow and its feed rate.

use crate::infill::FillKind;
use crate::region::BeadKind;
use crate::settings::SpeedSettings;
use crate::settings::flow::FlowRole;
use crate::support::StrandKind;

/// What an extruded line is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// An inner wall.
    Perimeter,
    /// The outermost wall.
    ExternalPerimeter,
    /// A wall with nothing below it.
    OverhangPerimeter,
    /// Sparse infill.
    InternalInfill,
    /// Solid infill inside the part or on its underside.
    SolidInfill,
    /// Solid infill on an upper surface.
    TopSolidInfill,
    /// A hot pass over an upper surface.
    Ironing,
    /// Infill across a gap.
    BridgeInfill,
    /// A line between two walls that do not meet.
    GapFill,
    /// Loops around the print, and the brim.
    Skirt,
    /// Support.
    SupportMaterial,
    /// The layers of support that touch the part.
    SupportInterface,
    /// Purged filament.
    WipeTower,
    /// The user's own G-code.
    Custom,
}

impl Role {
    /// Number of roles.
    pub const COUNT: usize = 14;

    /// Every role, in the order of [`Role::index`].
    pub const ALL: [Self; Self::COUNT] = [
        Self::Perimeter,
        Self::ExternalPerimeter,
        Self::OverhangPerimeter,
        Self::InternalInfill,
        Self::SolidInfill,
        Self::TopSolidInfill,
        Self::Ironing,
        Self::BridgeInfill,
        Self::GapFill,
        Self::Skirt,
        Self::SupportMaterial,
        Self::SupportInterface,
        Self::WipeTower,
        Self::Custom,
    ];

    /// Place in a table with one entry per role, 0..[`Role::COUNT`].
    pub const fn index(self) -> usize {
        self as usize
    }

    /// The name in `;TYPE:` comments, by which PrusaSlicer's viewer and those modelled on it colour
    /// the line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Perimeter => "Perimeter",
            Self::ExternalPerimeter => "External perimeter",
            Self::OverhangPerimeter => "Overhang perimeter",
            Self::InternalInfill => "Internal infill",
            Self::SolidInfill => "Solid infill",
            Self::TopSolidInfill => "Top solid infill",
            Self::Ironing => "Ironing",
            Self::BridgeInfill => "Bridge infill",
            Self::GapFill => "Gap fill",
            Self::Skirt => "Skirt/Brim",
            Self::SupportMaterial => "Support material",
            Self::SupportInterface => "Support material interface",
            Self::WipeTower => "Wipe tower",
            Self::Custom => "Custom",
        }
    }

    /// What `gcode_comments` writes behind a line of this role.
    pub const fn comment(self) -> &'static str {
        match self {
            Self::Perimeter => "perimeter",
            Self::ExternalPerimeter => "external perimeter",
            Self::OverhangPerimeter => "overhang perimeter",
            Self::InternalInfill => "infill",
            Self::SolidInfill => "solid infill",
            Self::TopSolidInfill => "top solid infill",
            Self::Ironing => "ironing",
            Self::BridgeInfill => "bridge infill",
            Self::GapFill => "gap fill",
            Self::Skirt => "skirt",
            Self::SupportMaterial => "support material",
            Self::SupportInterface => "support material interface",
            Self::WipeTower => "wipe tower",
            Self::Custom => "custom",
        }
    }

    /// The role of a wall `depth` walls in from the outline.
    pub const fn of_wall(depth: u32) -> Self {
        if depth == 0 { Self::ExternalPerimeter } else { Self::Perimeter }
    }

    /// The role of an infill line.
    pub const fn of_fill(kind: FillKind) -> Self {
        match kind {
            FillKind::Sparse => Self::InternalInfill,
            FillKind::Solid => Self::SolidInfill,
            FillKind::TopSolid => Self::TopSolidInfill,
            FillKind::Bridge | FillKind::InternalBridge => Self::BridgeInfill,
        }
    }

    /// Whose line width this role has.
    pub const fn flow(self) -> FlowRole {
        match self {
            Self::Perimeter | Self::GapFill => FlowRole::Perimeter,
            Self::ExternalPerimeter | Self::OverhangPerimeter => FlowRole::ExternalPerimeter,
            Self::InternalInfill | Self::WipeTower | Self::Custom => FlowRole::Infill,
            Self::SolidInfill | Self::BridgeInfill => FlowRole::SolidInfill,
            Self::TopSolidInfill | Self::Ironing => FlowRole::TopSolidInfill,
            Self::Skirt => FlowRole::Skirt,
            Self::SupportMaterial => FlowRole::Support,
            Self::SupportInterface => FlowRole::SupportInterface,
        }
    }

    /// True for lines that hang in air, which have a flow, a speed and a fan of their own.
    pub const fn is_bridge(self) -> bool {
        matches!(self, Self::BridgeInfill | Self::OverhangPerimeter)
    }

    /// The role of a bead of varying width.
    pub const fn of_bead(kind: BeadKind) -> Self {
        match kind {
            BeadKind::ThinWall => Self::ExternalPerimeter,
            BeadKind::GapFill => Self::GapFill,
        }
    }

    /// The role of a line beside the part.
    pub const fn of_strand(kind: StrandKind) -> Self {
        match kind {
            StrandKind::Base => Self::SupportMaterial,
            StrandKind::Interface => Self::SupportInterface,
            StrandKind::Brim => Self::Skirt,
        }
    }

    /// Feed rate away from the first layer and before any limit \[mm/s\].
    ///
    /// Percentages chain as in PrusaSlicer: top solid infill on solid infill on infill, external
    /// walls on inner ones. Roles without a setting of their own take the nearest one's.
    pub fn speed(self, speeds: &SpeedSettings) -> f64 {
        let solid = speeds.solid_infill_speed.of(speeds.infill_speed);
        match self {
            Self::ExternalPerimeter => speeds.external_perimeter_speed.of(speeds.perimeter_speed),
            Self::OverhangPerimeter | Self::BridgeInfill => speeds.bridge_speed,
            Self::GapFill => speeds.gap_fill_speed,
            Self::InternalInfill | Self::WipeTower => speeds.infill_speed,
            Self::SolidInfill => solid,
            Self::TopSolidInfill | Self::Ironing => speeds.top_solid_infill_speed.of(solid),
            Self::SupportMaterial => speeds.support_material_speed,
            Self::SupportInterface => {
                speeds.support_material_interface_speed.of(speeds.support_material_speed)
            }
            _ => speeds.perimeter_speed,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::FloatOrPercent::Percent;

    #[test]
    fn the_table_and_the_index_agree() {
        for (i, role) in Role::ALL.into_iter().enumerate() {
            assert_eq!(role.index(), i, "{role:?}");
        }
    }

    #[test]
    fn percentages_of_speeds_chain() {
        let speeds = SpeedSettings {
            infill_speed: 80.0,
            solid_infill_speed: Percent(50.0),
            top_solid_infill_speed: Percent(25.0),
            ..SpeedSettings::default()
        };
        assert_eq!(Role::TopSolidInfill.speed(&speeds), 10.0);
        assert_eq!(Role::ExternalPerimeter.speed(&speeds), 30.0);
    }
}
