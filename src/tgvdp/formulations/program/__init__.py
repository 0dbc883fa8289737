"""The models as mixed-integer programs: `binary`, `demand` with its `approximations`, and LP and MPS `files`."""
