export { kinematicsOf, stageOn, shade };
