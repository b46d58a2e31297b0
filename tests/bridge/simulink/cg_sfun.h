/* In place of what Simulink appends to an S-function: its host calls the functions above by their names. */
