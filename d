{
  "jink": "filter",
  "version": 1,
  "units": "SI",
  "filter": "AdaptiveIMM",
  "motions": [
    {
      "kind": "AccelerationLevel",
      "motion": {
        "kind": "ConstantVelocity",
        "acceleration_sd": 0.3
      },
      "acceleration": [
        0.0,
        0.0
      ],
      "estimated": true,
      "in_sd": false
    },
    {
      "kind": "AccelerationLevel",
      "motion": {
        "kind": "ConstantVelocity",
        "acceleration_sd": 0.3
      },
      "acceleration": [
        -3.0,
        0.0
      ],
      "estimated": true,
      "in_sd": false
    },
    {
      "kind": "AccelerationLevel",
      "motion": {
        "kind": "ConstantVelocity",
        "acceleration_sd": 0.3
      },
      "acceleration": [
        3.0,
        0.0
      ],
      "estimated": true,
      "in_sd": false
    },
    {
      "kind": "AccelerationLevel",
      "motion": {
        "kind": "ConstantVelocity",
        "acceleration_sd": 0.3
      },
      "acceleration": [
        0.0,
        -3.0
      ],
      "estimated": true,
      "in_sd": false
    },
    {
      "kind": "AccelerationLevel",
      "motion": {
        "kind": "ConstantVelocity",
        "acceleration_sd": 0.3
      },
      "acceleration": [
        0.0,
        3.0
      ],
      "estimated": true,
      "in_sd": false
    }
  ],
  "sensors": [
    {
      "kind": "Position",
      "sd": 10.0,
      "axes": 2
    }
  ],
  "estimator": {
    "kind": "TwoStageAcceleration",
    "acceleration_sd": 0.075,
    "bias_sd": 0.75,
    "bias_prior_sd": 2.37
  },
  "transition": {
    "kind": "Sojourn",
    "seconds": [
      32.70435205393184,
      32.70435205393184,
      32.70435205393184,
      32.70435205393184,
      32.70435205393184
    ]
  },
  "mode_probability": [
    0.6,
    0.1,
    0.1,
    0.1,
    0.1
  ],
  "mixing": "prior",
  "linearisation": "ekf",
  "initial": {
    "kind": "TwoPoint",
    "velocity_sd": 1000.0,
    "bounded": false
  }
}
