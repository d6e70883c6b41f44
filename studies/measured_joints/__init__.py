"""The model beside three measured granodiorite joints."""
